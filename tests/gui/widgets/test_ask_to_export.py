"""Files to be read are not hidden; the format, or the suffix, says how a file is written."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QWidget

from app.widgets.forms.form_dialog import (
    ask_to_export,
    file_filter,
)
from stereotrack_core.project.exporting.formats import format_named, formats_of

FORMATS = formats_of("run")


@pytest.mark.parametrize(
    ("chosen", "name", "form"),
    [
        ("run.csv", "csv", "csv"),
        ("run.csv", "c3d", "c3d"),
        ("run.csv", "angles", "angles"),
        ("walk.trc", "csv", "trc"),
        ("walk", "trc", "trc"),
        ("walk.2", "bvh", "bvh"),
    ],
)
def test_format_and_suffix(qtbot, shown, tmp_path, chosen, name, form):
    parent, found = QWidget(), []
    shown(parent, 300, 200)
    ask_to_export(parent, "Save", tmp_path / "run.csv", FORMATS, lambda *what: found.append(what))
    dialog = parent.findChild(QFileDialog)
    dialog.selectNameFilter(file_filter(format_named(name)))
    dialog.fileSelected.emit(str(tmp_path / chosen))
    path, written = found[0]
    assert written.name == form
    assert path.suffix in written.suffixes
    if path != tmp_path / chosen:  # nobody was asked about that file
        path.touch()
        dialog.fileSelected.emit(str(tmp_path / chosen))
        assert found[1][0] != path
    assert Path(chosen).stem.split(".")[0] in path.name
    dialog.close()
