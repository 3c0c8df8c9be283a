"""Files and folders that appear completely or not at all."""

from pathlib import Path

import pytest

from stereotrack_core.atomic import filling, replacing, write_file, write_files
from stereotrack_core.errors import Cancelled, InputError


@pytest.fixture
def older(tmp_path) -> Path:
    path = tmp_path / "a.txt"
    path.write_text("older")
    return path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("content", ["ä ± 1\r\n\n", b"\xff\0", "", b""])
def test_what_is_written_is_what_was_given(older, content):
    write_file(older, content)
    assert older.read_bytes() == (content.encode() if isinstance(content, str) else content)
    assert names(older.parent) == ["a.txt"]


def test_files_that_belong_together_are_written_together(older):
    beside = older.with_name("b.txt")
    write_files({older: "newer", beside: "new"})
    assert (older.read_text(), beside.read_text()) == ("newer", "new")
    with pytest.raises(InputError, match="absent"):
        write_files({older: "newest", beside: "newest", older.parent / "absent" / "c": ""})
    assert (older.read_text(), beside.read_text()) == ("newer", "new")
    assert names(older.parent) == ["a.txt", "b.txt"]


@pytest.mark.parametrize("error", [None, OSError("short"), ValueError, InputError("x", remedy="")])
def test_what_cannot_be_read_back_replaces_nothing(older, error):
    def is_whole(path: Path) -> bool:
        assert path.read_text() == "half"
        if error is not None:
            raise error
        return False

    with (
        pytest.raises(InputError, match="not all data reached the drive") as refused,
        replacing(older, is_whole) as temporary,
    ):
        temporary.write_text("half")
    assert refused.value.where == str(older)
    assert older.read_text() == "older"
    assert names(older.parent) == ["a.txt"]


def test_a_new_folder_appears_with_everything_in_it(tmp_path):
    folder = tmp_path / "deep" / "new"
    with filling(folder) as workplace:
        write_file(workplace / "a.txt", "a")
        assert not folder.exists()
    assert names(folder) == ["a.txt"]
    assert names(folder.parent) == ["new"]


@pytest.mark.parametrize("there", [True, False])
@pytest.mark.parametrize("error", [OSError(28, "No space left"), Cancelled(), InputError])
def test_a_folder_that_was_not_filled_is_as_it_was(tmp_path, there, error):
    folder = tmp_path / "folder"
    if there:
        folder.mkdir()
        (folder / "a.txt").write_text("older")

    def fill() -> None:
        with filling(folder) as workplace:
            write_file(workplace / "a.txt", "newer")
            if error is InputError:
                write_file(workplace / "absent" / "b.txt", "")
            raise error

    with pytest.raises((InputError, Cancelled)) as failed:
        fill()
    if isinstance(failed.value, InputError):
        assert failed.value.where.startswith(str(folder))
    assert names(tmp_path) == (["folder"] if there else [])
    if there:
        assert names(folder) == ["a.txt"]
        assert (folder / "a.txt").read_text() == "older"
