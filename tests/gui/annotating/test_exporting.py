"""Clicks and references are written from the window in the formats of the export command."""

from __future__ import annotations

import json

import numpy as np
from PySide6.QtCore import Qt

from app.features.annotate.exchange.click_files import ExportDialog, ReferenceExportDialog
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.labels import read_clicks
from stereotrack_core.interop.reference_npz import read_reference
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.project.clicks import place
from stereotrack_core.project.exporting import formats
from stereotrack_core.project.exporting.formats import names_of
from stereotrack_core.recording.landmarks import read_landmarks
from tests.gui.annotating.stage import LEFT, select, settled


def test_the_selection_is_exported(qtbot, project, stage, tmp_path):
    select(qtbot, stage, 5, 25)
    stage.trigger("export-selection")
    settled(qtbot, stage)
    dialog = stage.findChild(ExportDialog)
    assert dialog.choice.currentText() == "Only frames 5 – 25"
    dialog.path.setText(str(tmp_path / "out"))
    qtbot.keyClick(dialog.path, Qt.Key.Key_Tab)
    assert dialog.preview.text() == "72 clicks in 2 frames will be written."
    qtbot.mouseClick(dialog.accept_button, LEFT)
    settled(qtbot, stage)
    found = read_clicks(tmp_path / "out.csv", stage.panels.recording).checked()
    assert {click.frame for click in found} == {10, 20}
    project.apply(place(found[0]))
    stage.trigger("export")
    settled(qtbot, stage)
    again = stage.findChildren(ExportDialog)[-1]
    again.path.setText(str(tmp_path / "out.csv"))
    qtbot.keyClick(again.path, Qt.Key.Key_Return)
    assert "Of the 72 clicks in the existing file, 72 stay the same and 0 change; 144 are new" in (
        again.preview.text()
    )
    assert not again.words.isVisible()
    settled(qtbot, stage)


def test_clicks_are_exported_in_every_format(qtbot, stage, tmp_path, monkeypatch):
    stage.trigger("export")
    settled(qtbot, stage)
    again = stage.findChild(ExportDialog)
    again.path.setText(str(tmp_path / "out.csv"))
    box = again.format_box
    assert {box.itemData(k) for k in range(box.count())} == set(names_of("clicks"))
    monkeypatch.setattr(formats, "find_spec", lambda _module: None)
    for name in ("csv", "slp", "coco"):
        box.setCurrentIndex(box.findData(name))
        box.activated.emit(box.currentIndex())
        assert ("pip install 'stereotrack[sleap]'" in again.words.text()) is (name == "slp")
        assert again.accept_button.isEnabled() is (name != "slp")
    qtbot.mouseClick(again.accept_button, LEFT)
    settled(qtbot, stage)
    assert str(tmp_path / "out.json") in stage.heard[-1]
    assert len(json.loads((tmp_path / "out.json").read_text())["images"]) == 24


def test_the_reference_is_exported_as_far_as_it_is_known(qtbot, stage, tmp_path):
    assert not stage.book.action("annotate-export-reference").isEnabled()
    stage.trigger("fit")
    settled(qtbot, stage)
    reference = stage.panels.reference.now.reference
    for name, limit in (("csv", 10_000.0), ("npz", 10_000.0), ("c3d", 10_000.0), ("trc", 30.0)):
        stage.trigger("export-reference")
        dialog = stage.findChildren(ReferenceExportDialog)[-1]
        assert dialog.limit.value() == 100.0
        assert "Left out: " in dialog.preview.text()
        dialog.limit.setValue(limit)
        assert ("Left out: " in dialog.preview.text()) is (name == "trc")
        dialog.format_box.setCurrentIndex(dialog.format_box.findData(name))
        dialog.format_box.activated.emit(dialog.format_box.currentIndex())
        assert ("cannot store: standard deviations" in dialog.preview.text()) is (
            name in ("trc", "c3d")
        )
        dialog.path.setText(str(tmp_path / f"reference.{name}"))
        qtbot.mouseClick(dialog.accept_button, LEFT)
        settled(qtbot, stage)
        assert f"reference.{name}" in stage.heard[-1]
    known = read_landmarks(tmp_path / "reference.csv")
    np.testing.assert_allclose(known.points, stage.panels.reference.now.fit.nine, atol=1e-5)
    again = read_reference(tmp_path / "reference.npz")
    np.testing.assert_array_equal(again.limb_sigma_deg, reference.limb_sigma_deg)
    assert len(read_trajectory(tmp_path / "reference.c3d").frame) == len(known.frame)
    few = np.isfinite(read_trajectory(tmp_path / "reference.trc").points).all(axis=2)
    np.testing.assert_array_equal(few, reference.sigma() <= 0.03)
    assert "Left out: " in stage.heard[-1]


def test_landmark_sets_are_exported_changed_in_a_text_editor_and_imported(stage, project, tmp_path):
    stage.dialogs.export_landmarks(tmp_path / "set")
    file = tmp_path / "set.toml"
    text = file.read_text(encoding="utf-8")
    more = text.replace("nine landmarks", "with sternum") + (
        '\n[[landmarks]]\nname = "sternum"\ncolour = "#112233"\nlimb = "torso"\npart = "torso"\n'
    )
    file.write_text(more, encoding="utf-8")
    stage.dialogs.import_landmarks(file)
    assert project.landmark_set().names == (*NINE.names, "sternum")
    file.write_text(more.replace("#112233", "red"), encoding="utf-8")
    stage.dialogs.import_landmarks(file)
    assert "#rrggbb" in stage.problems[-1].sentence()
    file.write_text(text, encoding="utf-8")
    stage.dialogs.import_landmarks(file)
    assert project.landmark_set() == NINE
