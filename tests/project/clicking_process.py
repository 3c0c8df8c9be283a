"""A process that clicks as often as it is told to, and says of each click that it is saved.

It waits for a line on standard input before each click, so that the test sets the pace: with lines
in stock it clicks as fast as it can. After the last one it may begin an edit that it never ends.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.project.clicks import place
from stereotrack_core.project.project import Project

UNFINISHED = "unfinished"


def click(number: int) -> Click:
    """The click of that number; every one is of another frame."""
    return Click(number, "N_right", "head", (number % 60 + 0.5, 3.25))


def begin_what_never_ends(project: Project) -> None:
    """Write half an edit to the file, so much that it does not fit into memory."""
    with project._access.writing() as database:
        database.execute("PRAGMA cache_size = 1")
        database.execute("UPDATE click SET x = x + 1")
        database.execute("UPDATE edit_change SET after = after || ' '")
        os.write(1, b"half\n")
        sys.stdin.readline()


def main(path: Path) -> None:
    """Click at every line; the line ``unfinished`` begins an edit without an end."""
    number = 0
    with Project.open(path, who="A") as project:
        os.write(1, b"open\n")
        for line in sys.stdin:
            if line.strip() == UNFINISHED:
                begin_what_never_ends(project)
            project.apply(place(click(number)))
            os.write(1, f"{number}\n".encode())
            number += 1


if __name__ == "__main__":
    main(Path(sys.argv[1]))
