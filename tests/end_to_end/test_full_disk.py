"""A disk that is full: nothing is lost, and whoever asked is told."""

import functools
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from tests.end_to_end import writers
from tests.end_to_end.writers import FILES, FOLDERS, content_of, full_disk
from tests.reading.samples import Samples, made_samples

ROOT = Path(__file__).resolve().parents[2]
OLDER = b"what was there before\n"
ROOM: dict[str, Callable[[int], int]] = {
    "no room": lambda _: 0,
    "little room": lambda _: 20,
    "nearly enough": lambda needed: needed - 1,
}
ROOMS = ("no room", pytest.param("little room", marks=pytest.mark.slow), "nearly enough")


@pytest.fixture(scope="module")
def samples(tmp_path_factory) -> Samples:
    """A recording, a run of it and what else is written."""
    return made_samples(tmp_path_factory.mktemp("samples"))


@pytest.fixture(scope="module")
def enough(samples, tmp_path_factory) -> Callable[[str], dict[str, bytes]]:
    """Function that writes once where there is room, and gives the files that were made."""

    @functools.cache
    def made(name: str) -> dict[str, bytes]:
        folder = tmp_path_factory.mktemp("enough")
        (FILES | FOLDERS)[name](folder / name, samples)
        return content_of(folder)

    return made


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
def test_a_writer_says_so_and_leaves_what_was_there(name, room, samples, enough, tmp_path):
    if name == "sleap.slp":
        pytest.importorskip("sleap_io")
    made = enough(name)
    before = with_older_files(tmp_path / "full", made)
    room = ROOM[room](max(map(len, made.values())))
    with full_disk(room), pytest.raises(InputError) as refused:
        (FILES | FOLDERS)[name](tmp_path / "full" / name, samples)
    assert content_of(tmp_path / "full") == before
    assert refused.value.where
    assert refused.value.remedy


def test_every_module_that_writes_files_is_tried():
    """Whoever adds a writer adds it to the list, or says here who tries it."""
    elsewhere = {
        "app.features.review.remedies": "the table of failures, tests/gui/test_failures.py",
        "app.shell.dialogs": "pictures of the window, tests/gui/test_picture_file.py",
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
        if set(", ".join(taken).split(", ")) - {
            "",
            "forget_unfinished",
            "make_folder",
            "take_lock",
        }:
            found.add(".".join(path.relative_to(ROOT).with_suffix("").parts))
    return found
