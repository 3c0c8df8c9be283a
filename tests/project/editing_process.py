"""A process that edits a project until it is killed, and says which edits were acknowledged.

The edits follow from a seed alone, so that the test knows what the project has to hold.
"""

from __future__ import annotations

import os
import random
import sys
from collections.abc import Iterator
from pathlib import Path

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.project.clicks import DeleteClicks, MoveClicks, PlaceClicks
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project

Step = Edit | str
"""An edit, ``undo`` or ``redo``."""

LANDMARKS = ("left_elbow", "right_elbow", "head")
CAMERAS = ("N_right", "S_cam")


def steps(seed: int) -> Iterator[Step]:
    """Edits without end: single ones, many clicks at once, undo and redo."""
    choose = random.Random(seed)
    while True:
        kind = choose.choices(("one", "many", "move", "delete", "undo", "redo"), (6, 1, 2, 2, 2, 1))
        match kind[0]:
            case "one":
                yield PlaceClicks((_click(choose, choose.randrange(40)),))
            case "many":
                first = choose.randrange(1000)
                yield PlaceClicks(tuple(_click(choose, first + i) for i in range(200)))
            case "move":
                yield MoveClicks((_key(choose),), (choose.uniform(-1, 1), 0.5))
            case "delete":
                yield DeleteClicks((_key(choose), _key(choose)))
            case word:
                yield word


def _key(choose: random.Random) -> ClickKey:
    return ClickKey(choose.randrange(40), choose.choice(CAMERAS), choose.choice(LANDMARKS))


def _click(choose: random.Random, frame: int) -> Click:
    position = (choose.uniform(0, 63), choose.uniform(0, 47))
    return Click(frame, choose.choice(CAMERAS), choose.choice(LANDMARKS), position)


def make(project: Project, step: Step) -> None:
    """Make an edit, or take one back, or make it again."""
    if step == "undo":
        project.undo()
    elif step == "redo":
        project.redo()
    else:
        assert isinstance(step, Edit)
        project.apply(step)


def edit_until_killed(path: Path, seed: int, interactive: bool) -> None:
    """Edit without end; a line on standard output acknowledges each edit."""
    os.write(1, f"{os.getpid()}\n".encode())
    with Project.open(path, who="A", interactive=interactive) as project:
        for step in steps(seed):
            make(project, step)
            os.write(1, b".\n")


def main() -> None:
    """For each line ``seed interactive path``, let a child edit, and say when it has ended.

    Children are forked, so that a hundred of them do not load the program a hundred times.
    """
    for line in sys.stdin:
        seed, interactive, path = line.rstrip("\n").split(" ", 2)
        child = os.fork()
        if child == 0:
            edit_until_killed(Path(path), int(seed), interactive == "True")
        _, status = os.waitpid(child, 0)
        os.write(1, f"ended {os.waitstatus_to_exitcode(status)}\n".encode())


if __name__ == "__main__":
    main()
