"""A disk that is full: nothing is lost, and whoever asked is told."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_npz import write_npz
from tests.end_to_end import writers
from tests.end_to_end.writers import FILES, FOLDERS, Things, content_of, full_disk
from tests.evaluation.failure_segments.runs import recorded

ROOT = Path(__file__).resolve().parents[2]
OLDER = b"what was there before\n"
ROOM: dict[str, Callable[[int], int]] = {
    "no room": lambda _: 0,
    "little room": lambda _: 20,
    "nearly enough": lambda needed: needed - 1,
}
ROOMS = ("no room", pytest.param("little room", marks=pytest.mark.slow), "nearly enough")


@pytest.fixture(scope="module")
def things(tmp_path_factory, qapp) -> Things:
    """A recording, and a run of it that fails twice."""
    folder = tmp_path_factory.mktemp("things")
    (folder / "recording").mkdir()
    failing = (("left_forearm", 4, 6, 1.4), ("right_forearm", 8, 10, 1.4))
    recording, run, truth = recorded(folder / "recording", 16, failing)
    write_npz(folder / "run.npz", run)
    return Things(recording, run, folder / "run.npz", truth)


@pytest.fixture(scope="module")
def enough(tmp_path_factory) -> Callable[[str, Callable[[Path], object]], dict[str, bytes]]:
    """Function that writes once where there is room, and gives the files that were made."""
    known: dict[str, dict[str, bytes]] = {}

    def made(name: str, write: Callable[[Path], object]) -> dict[str, bytes]:
        if name not in known:
            folder = tmp_path_factory.mktemp("enough")
            write(folder / name.split(": ")[-1])
            known[name] = content_of(folder)
            assert known[name]
        return known[name]

    return made


def largest(made: dict[str, bytes]) -> int:
    return max(len(content) for content in made.values())


NEEDED = {".slp": "sleap_io"}
"""Libraries that not everybody installs."""


def with_older_files(folder: Path, made: dict[str, bytes]) -> dict[str, bytes]:
    """Put an older file where each new file comes; nothing for a folder that is to be made."""
    folder.mkdir()
    if not all(made.values()):
        return {}
    for name in made:
        (folder / name).write_bytes(OLDER)
    return content_of(folder)


@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("name", [*FILES, *FOLDERS])
def test_a_writer_says_so_and_leaves_what_was_there(name, room, things, enough, tmp_path):
    if (library := NEEDED.get(Path(name).suffix)) is not None:
        pytest.importorskip(library)
    if name == "run.rrd" and room == "nearly enough":
        pytest.skip("it has another size every time")
    write = FILES[name] if name in FILES else FOLDERS[name]
    made = enough(name, lambda path: write(path, things))
    before = with_older_files(tmp_path / "full", made)
    with full_disk(ROOM[room](largest(made))), pytest.raises(InputError) as refused:
        write(tmp_path / "full" / name, things)
    assert content_of(tmp_path / "full") == before
    assert refused.value.where
    assert refused.value.remedy


def test_every_module_that_writes_files_is_tried():
    """Whoever adds a writer adds it to the list, or says here who tries it."""
    elsewhere = {
        "stereotrack_core.doctor.correcting": "a recording of its own, tests/doctor",
        "stereotrack_core.pose_model.installation": "files of its own, tests/pose_model",
        "stereotrack_core.project.database": "tests/project",
        "stereotrack_core.recording.importing.files": "part of importing.making",
        "stereotrack_core.study.store": "a text of its own, tests/cli/test_sweep.py",
    }
    by_commands = {"stereotrack_core.report.pages"}
    text = Path(writers.__file__).read_text(encoding="utf-8")
    tried = {*re.findall(r"^from (\S+) import", text, re.MULTILINE), *by_commands, *elsewhere}
    assert modules_that_write() - tried == set()
    assert set(elsewhere) <= modules_that_write()


def modules_that_write() -> set[str]:
    found = set()
    for path in (*(ROOT / "app").rglob("*.py"), *(ROOT / "stereotrack_core").rglob("*.py")):
        taken = re.findall(r"from stereotrack_core\.atomic import (.+)", path.read_text("utf-8"))
        if set(", ".join(taken).split(", ")) - {"", "forget_unfinished", "take_lock"}:
            found.add(".".join(path.relative_to(ROOT).with_suffix("").parts))
    return found
