"""``stereotrack completion``: commands and options at the press of the tabulator key."""

from __future__ import annotations

from argparse import Action, ArgumentParser, Namespace, _SubParsersAction
from pathlib import Path

from stereotrack_core.cli.arguments import option
from stereotrack_core.cli.output import OK, put
from stereotrack_core.versions import extra_library

SHELLS = ("bash", "zsh", "tcsh")

DESCRIPTION = (
    "Print a script by which a shell completes commands, options and files. It is made from the "
    "commands of this version: make it again after an update. Needs the library shtab."
)

OPTIONS = (option("shell SHELL", f"one of {', '.join(SHELLS)}", choices=SHELLS),)


def run(args: Namespace) -> int:
    """Print the script."""
    from stereotrack_core.cli.commands import program_parser  # which knows this module

    missing = "completion needs the library shtab, which is not installed"
    instead = "the list of commands that `stereotrack help` prints"
    shtab = extra_library("shtab", "completion", missing=missing, where="", instead=instead)
    parser = program_parser()
    for action in _actions(parser):
        if action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    put(shtab.complete(parser, args.shell))
    return OK


def _actions(parser: ArgumentParser) -> list[Action]:
    """What a parser takes, and what those of its commands do."""
    found: list[Action] = []
    for action in parser._actions:
        found.append(action)
        if isinstance(action, _SubParsersAction):
            for inner in action.choices.values():
                found += _actions(inner)
    return found
