"""Files to be read are not hidden; the format, or the suffix, says how a file is written."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from app.widgets.forms.form_dialog import ask_to_export, ask_to_save, file_filter
from stereotrack_core.project.exporting import format_named, formats_of

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


def test_a_file_that_the_suffix_names_is_asked_about(qtbot, tmp_path, monkeypatch):
    parent, found, there = QWidget(), [], tmp_path / "mine.toml"
    qtbot.addWidget(parent)
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda *_, **__: (str(tmp_path / "mine"), "")
    )
    answers = iter([QMessageBox.StandardButton.No, QMessageBox.StandardButton.Yes])
    monkeypatch.setattr(QMessageBox, "question", lambda *_: next(answers))
    for expected in ([there], [there], [there, there]):  # new, refused, replaced
        ask_to_save(parent, "Export preset", "preset.toml", "Preset (*.toml)", found.append)
        assert found == expected
        there.touch()
