"""``stereotrack help``: all commands, or the help of one."""

from __future__ import annotations

from argparse import Namespace

from stereotrack_core.cli.arguments import option
from stereotrack_core.cli.commands import command_list, command_named, parser_of
from stereotrack_core.cli.output import OK, put

DESCRIPTION = "List all commands, or show the help of one command."

OPTIONS = (option("command_name COMMAND", "a command (default: list all commands)", nargs="?"),)


def run(args: Namespace) -> int:
    """Print the list, or the command's own help."""
    if args.command_name is None:
        put(command_list())
    else:
        parser_of(command_named(args.command_name)).print_help()
    return OK
