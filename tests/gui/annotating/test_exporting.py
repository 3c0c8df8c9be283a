"""Clicks and references are written from the window in the formats of the export command."""

import json

import numpy as np
from PySide6.QtWidgets import QFileDialog

from app.widgets.forms.form_dialog import FormDialog, file_filter
from app.widgets.forms.numbers import NumberField
from stereotrack_core.interop.labels import read_clicks
from stereotrack_core.interop.reference_npz import read_reference
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.project import exporting
from stereotrack_core.project.exporting import format_named, formats_of
from stereotrack_core.recording.landmarks import read_landmarks
from tests.gui.annotating.stage import settled


def accept_limit(stage, millimetres=None):
    """Press OK where the limit of sigma is asked for, perhaps with another one; the limit."""
    dialog = stage.findChildren(FormDialog)[-1]
    field = dialog.findChild(NumberField)
    if millimetres is not None:
        field.setValue(millimetres)
    shown = field.value()
    dialog.accept_button.click()
    return shown


def choose(qtbot, stage, name, path):
    """Choose a format and a file in the dialog that is open, and wait until it is written."""
    dialog = stage.findChildren(QFileDialog)[-1]
    dialog.selectNameFilter(file_filter(format_named(name)))
    dialog.fileSelected.emit(str(path))
    dialog.close()
    settled(qtbot, stage)


def test_clicks_are_exported_in_every_format(qtbot, stage, tmp_path, monkeypatch):
    stage.trigger("export")
    filters = stage.findChild(QFileDialog).nameFilters()
    assert filters == list(map(file_filter, formats_of("clicks")))
    choose(qtbot, stage, "csv", tmp_path / "clicks.csv")
    found = read_clicks(tmp_path / "clicks.csv", stage.panels.recording).checked()
    assert f"{len(found)} clicks saved to" in stage.heard[-1]
    stage.trigger("export")
    choose(qtbot, stage, "coco", tmp_path / "out.json")
    assert str(tmp_path / "out.json") in stage.heard[-1]
    assert "cannot store" not in stage.heard[-1]
    assert len(json.loads((tmp_path / "out.json").read_text())["images"]) == 24
    stage.trigger("export")
    choose(qtbot, stage, "dlc", tmp_path / "out.csv")
    assert "more file" in stage.heard[-1], "the number is of the first file alone"
    monkeypatch.setattr(exporting, "find_spec", lambda _module: None)
    assert "not installed" in file_filter(format_named("slp"))


def test_the_reference_is_exported_as_far_as_it_is_known(qtbot, stage, tmp_path):
    assert not stage.book.action("annotate-export-reference").isEnabled()
    stage.trigger("fit")
    settled(qtbot, stage)
    reference = stage.panels.reference.now.reference
    for name in ("csv", "npz", "trc"):
        stage.trigger("export-reference")
        dialog = stage.findChildren(FormDialog)[-1]
        dialog.findChild(NumberField).setValue(20.0)
        assert reference.left_out(0.02) in dialog.words.text(), "before it is decided"
        accept_limit(stage, 100.0)
        choose(qtbot, stage, name, tmp_path / f"reference.{name}")
        assert f"reference.{name}" in stage.heard[-1]
        assert "Left out: " in stage.heard[-1]
        assert ("cannot store: covariances" in stage.heard[-1]) is (name != "npz")
    assert (
        (tmp_path / "reference.trc.provenance.csv")
        .read_text()
        .splitlines()[0]
        .endswith("source,annotator,visibility,views,residual_px")
    )
    sure = reference.sigma() <= 0.1
    known = read_landmarks(tmp_path / "reference.csv").points
    np.testing.assert_allclose(known[sure], stage.panels.reference.now.fit.nine[sure], atol=1e-5)
    assert np.isnan(known[~sure]).all()
    again = read_reference(tmp_path / "reference.npz")
    np.testing.assert_array_equal(again.limb_sigma_deg, reference.limb_sigma_deg)
    few = np.isfinite(read_trajectory(tmp_path / "reference.trc").points).all(axis=2)
    np.testing.assert_array_equal(few, sure)


def test_the_limit_of_the_reference_is_asked_and_proposed_again(qtbot, stage, tmp_path):
    stage.trigger("fit")
    settled(qtbot, stage)
    stage.trigger("export-reference")
    accept_limit(stage, 4.0)
    choose(qtbot, stage, "csv", tmp_path / "sure.csv")
    assert "standard deviation above 4 mm" in stage.heard[-1]
    sure = stage.panels.reference.now.reference.sigma() <= 0.004
    known = np.isfinite(read_landmarks(tmp_path / "sure.csv").points).all(axis=2)
    np.testing.assert_array_equal(known, sure)
    stage.trigger("export-reference")
    assert accept_limit(stage) == 4.0
