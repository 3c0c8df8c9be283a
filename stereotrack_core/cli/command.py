"""What a command is."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass

OK, FAILED, WRONG_INPUT = 0, 1, 2
"""Exit status: done; something else went wrong, or it was stopped; the user's input is wrong."""


@dataclass(frozen=True)
class Command:
    """One command of the program.

    Attributes
    ----------
    name : str
    summary : str
        One line for the list of commands.
    description : str
        Paragraph for the command's own help.
    add_arguments : callable
        Declares the arguments on a parser.
    run : callable
        Does the work and returns the exit status.
    """

    name: str
    summary: str
    description: str
    add_arguments: Callable[[ArgumentParser], None]
    run: Callable[[Namespace], int]
