"""Every landmark of every frame says where it comes from, in the project and in every export."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import merged_reference, reference_of_fit
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_clicks, read_labels
from stereotrack_core.interop.reference_npz import (
    read_reference,
    read_reference_table,
    reference_bytes,
    reference_of_bytes,
)
from stereotrack_core.interop.run_file import reference_in
from stereotrack_core.project.exporting import (
    FORMATS,
    ClickedRecording,
    export_clicks,
    export_reference,
)
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.recording.small import filmless

AT = "2026-05-01T12:00:00+00:00"


def click(landmark, camera, origin="hand", who="A", **more):
    return Click(0, camera, landmark, (10.5, 20.25), origin=origin, who=who, at=AT, **more)


OUTSIDE = Click(0, "S", "right_hand", None, Visibility.OUTSIDE, who="A", at=AT)
CLICKS = (
    click("head", "N", flag="uncertain"),
    click("head", "S", "accepted", "B", visibility=Visibility.GUESSED),
    click("left_hand", "N", "accepted", visibility=Visibility.GUESSED, sigma=2.5),
    click("left_elbow", "N", "detector"),
    click("left_hip", "S", "imported", who=""),
    OUTSIDE,
)


@pytest.fixture
def recording(tmp_path):
    return filmless(tmp_path / "r", "N", "S")


@pytest.fixture
def reference():
    """Frames 0 to 3: clicked, interpolated, without a left hand, and a gap."""
    points = np.random.default_rng(0).normal(size=(4, 9, 3))
    points[2, LANDMARKS.index("left_hand")] = points[3] = np.nan
    residual = {one.key: np.array([3.0, 4.0]) for one in CLICKS if one.position}
    residual[ClickKey(0, "S", "head")] = np.zeros(2)
    covariance = np.broadcast_to(1e-4 * np.eye(3), (4, 9, 3, 3)).copy()
    covariance[1, :3] *= 4
    fit = TrajectoryFit(
        LANDMARKS, np.arange(4), points, covariance, np.full((4, 6), 2.0),
        np.array([CLICKED, INTERPOLATED, INTERPOLATED, GAP]), points, residual, {},
    )  # fmt: skip
    return reference_of_fit(fit, {"fps": 10.0}, CLICKS)


def of(reference, frame, landmark):
    """What is known of a landmark, unknown numbers as None."""
    column = reference.landmark_names.index(landmark)
    row = reference.frame.tolist().index(frame)
    values = [array[row, column] for array in reference.provenance.arrays().values()]
    return tuple(
        str(v) if isinstance(v, str) else None if np.isnan(v) else float(v) for v in values
    )


def test_each_source_is_told_from_the_others(reference):
    assert of(reference, 0, "head") == ("clicked", "A+B", 2, 2, pytest.approx(np.sqrt(12.5)))
    assert of(reference, 0, "left_hand") == ("accepted", "A", 1, 1, 5)
    assert of(reference, 0, "left_elbow") == ("detector", "A", 2, 1, 5)
    assert of(reference, 0, "left_hip") == ("imported", "", 2, 1, 5)
    assert of(reference, 0, "right_hand") == ("fit", "A", 0, 0, None)
    assert of(reference, 0, "right_hip") == ("fit", "", None, 0, None)
    assert of(reference, 1, "head") == ("interpolated", "", None, 0, None)
    assert of(reference, 2, "left_hand") == ("", "", None, None, None)
    assert of(reference, 3, "head") == ("", "", None, None, None)


def same(one, two, digits=6):
    for name, array in one.provenance.arrays().items():
        other = two.provenance.arrays()[name]
        if array.dtype.kind == "U":
            np.testing.assert_array_equal(array, other)
        else:
            np.testing.assert_allclose(array, other, atol=10.0**-digits)


def test_it_survives_npz_and_csv_and_other_rates(reference, tmp_path):
    same(reference, reference_of_bytes(reference_bytes(reference), "r"))
    export_reference(tmp_path / "r.csv", reference, FORMATS[0], None)
    again = read_reference_table(tmp_path / "r.csv")
    same(reference, again, 3)
    np.testing.assert_array_equal(again.filled, [False, True, True, False])
    twice = reference.at_rate(20.0, "r")
    assert of(twice, 0, "head") == of(reference, 0, "head")
    assert of(twice, 1, "head") == ("interpolated", "", None, None, None)
    assert of(twice, 2, "head") == of(reference, 1, "head")
    same(reference, merged_reference(reference, reference, range(1, 3)))


def test_files_without_it_open_and_state_nothing(reference, tmp_path):
    bare = replace(reference, provenance=None)
    assert reference_of_bytes(reference_bytes(bare), "r").provenance is None
    path = tmp_path / "r.csv"
    export_reference(path, bare, FORMATS[0], None)
    assert of(read_reference_table(path), 0, "head") == ("fit", "", None, None, None)
    path.write_text("frame,landmark,x,y,z\n0,head,1,2,3\n")
    assert read_reference_table(path).provenance is None


@pytest.mark.parametrize("form", [one for one in FORMATS if one.reference], ids=lambda f: f.name)
def test_every_export_of_a_reference_keeps_it_or_has_it_beside(reference, tmp_path, form):
    path = tmp_path / f"r{form.suffixes[0]}"
    written = export_reference(path, reference, form, 10.0, 0.015)
    kept = [one for one in written.files if one.name.endswith(".provenance.csv")]
    assert (len(kept), len(written.files)) == ((0, 1) if form.name in ("csv", "npz") else (1, 2))
    again = read_reference(path) if form.name == "npz" else reference_in((*kept, path)[0])
    same(reference, again, 3)
    assert "3 with a standard deviation above 15 mm" in " ".join(written.notes)
    np.testing.assert_allclose(again.sigma()[1, :3], 0.02)
    assert np.isnan(again.points[1, :3]).all()


@pytest.mark.parametrize("form", [one for one in FORMATS if one.clicks], ids=lambda f: f.name)
def test_every_export_of_clicks_keeps_it_or_has_it_beside(recording, tmp_path, form):
    if form.module:
        pytest.importorskip(form.module)
    path = tmp_path / f"c{form.suffixes[0]}"
    written = export_clicks(path, ClickedRecording(CLICKS, recording, NINE), form)
    beside = path.with_name(f"{path.name}.provenance.csv")
    assert (beside in written.files) is (form.name in ("slp", "dlc"))
    if beside in written.files:
        found = read_clicks(beside, recording)
    else:
        found = read_labels(LabelSource(path, recording, NINE.names))
    assert set(found.checked()) == set(CLICKS)
    assert found.unstated == ()


@pytest.mark.parametrize(("column", "text"), [("sigma", "-1"), ("sigma", "x"), ("time", "noon")])
def test_senseless_provenance_is_named(recording, tmp_path, column, text):
    path = tmp_path / "c.csv"
    path.write_text(f"frame,view,landmark,x,y,visibility,{column}\n0,N,head,1,2,2,{text}\n")
    with pytest.raises(InputError, match=f"'{text}' is not a"):
        read_clicks(path, recording).checked()
