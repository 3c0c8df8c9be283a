"""A correction is made only where the checks that asked for it are content then."""

import shutil

import pytest

from stereotrack_core.doctor import correcting
from stereotrack_core.doctor.correcting import correct, correct_all, intended, remains
from stereotrack_core.doctor.slips import transposed
from stereotrack_core.errors import Correction, Finding, InputError
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.findings import examine
from tests.end_to_end.writers import content_of, full_disk
from tests.recording.small import written_recording


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """The small recording, written once."""
    return written_recording(tmp_path_factory.mktemp("small")).folder


@pytest.fixture
def wrong(pictures, tmp_path, monkeypatch):
    """A copy in which the rotations of view O are transposed; its noise is not measured."""
    folder = shutil.copytree(pictures, tmp_path / "small")
    path = folder / "calibration.toml"
    cameras = read_calibration(path)
    change = {n: transposed(c) if n[0] == "O" else c for n, c in cameras.items()}
    write_calibration(path, change)
    monkeypatch.setattr(correcting, "diagnose", lambda *_: ())
    return folder


def test_what_is_found_is_corrected_and_the_file_before_is_kept(wrong):
    [finding] = [one for one in examine(wrong) if one.severity != "note"]
    assert finding.correction == Correction("transpose", ("O_left", "O_right"))
    assert "Transpose the rotation of O_left and O_right" in intended(wrong, finding.correction)
    before = (wrong / "calibration.toml").read_bytes()
    done = correct(wrong, finding)
    assert done.kept.read_bytes() == before
    assert done.kept.name == "calibration-before-1.toml"
    assert not [one for one in examine(wrong) if one.severity != "note"]


@pytest.mark.parametrize("kind", ["invert", "exchange_centre"])
def test_nothing_is_changed_where_the_problem_would_remain(wrong, kind):
    [finding] = [one for one in examine(wrong) if one.severity != "note"]
    other = Finding(
        finding.severity, finding.where, finding.what, "", Correction(kind, ("O_left", "O_right"))
    )
    before = content_of(wrong)
    with pytest.raises(InputError, match="stays as it was"):
        correct(wrong, other)
    assert content_of(wrong) == before


def test_what_cannot_be_read_then_is_not_written(wrong):
    finding = Finding("warning", "reference.csv", "late", "", Correction("resize", ("O_left",), 0))
    before = content_of(wrong)
    with pytest.raises(InputError, match="focal lengths"):
        correct(wrong, finding)
    assert content_of(wrong) == before


def test_a_correction_that_would_bring_another_error_is_none(wrong):
    finding = Finding(
        "error", "view S", "far", "", Correction("scale_translation", ("S_left", "S_right"), 1000.0)
    )
    before = content_of(wrong)
    with pytest.raises(InputError, match="there would be another one"):
        correct(wrong, finding)
    assert content_of(wrong) == before


@pytest.mark.parametrize("room", [0, 1000])
def test_a_full_disk_leaves_everything_as_it_was(wrong, room):
    [finding] = [one for one in examine(wrong) if one.severity != "note"]
    before = content_of(wrong)
    with full_disk(room), pytest.raises(InputError, match="could not be written"):
        correct(wrong, finding)
    assert content_of(wrong) == before


def test_all_corrections_are_tried_and_told(wrong):
    told = []
    found = (
        *examine(wrong),
        Finding("error", "view S", "shaken", "", Correction("shift_frames", ("S",), -1.0)),
    )
    [done] = correct_all(wrong, found, told.append)
    assert done.words == "Transpose the rotation of O_left and O_right."
    assert told[2] == "Corrected. The file before is calibration-before-1.toml."


def test_a_problem_remains_by_other_numbers_or_as_a_graver_one():
    given = Finding("warning", "view N", "rows lie 2.1 px apart", "")
    assert remains(given, [Finding("warning", "view N", "rows lie 1.4 px apart", "")])
    assert remains(given, [Finding("error", "view N", "all is black", "")])
    assert not remains(given, [Finding("note", "view N", "rows lie 1.4 px apart", "")])
    assert not remains(given, [Finding("warning", "view S", "rows lie 2.1 px apart", "")])
