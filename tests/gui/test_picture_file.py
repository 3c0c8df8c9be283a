"""Pictures of the window as files."""

import pytest
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import QFileDialog

from app.shell.dialogs import write_picture
from stereotrack_core.errors import InputError
from tests.end_to_end.writers import full_disk
from tests.gui.hands import trigger

pytestmark = pytest.mark.window


@pytest.mark.parametrize("name", ["a.png", "a.PNG", "a.jpg"])
def test_a_picture_is_written_as_its_name_says(qapp, tmp_path, name):
    picture = QPixmap(40, 30)
    picture.fill()
    write_picture(tmp_path / name, picture)
    assert QImage(str(tmp_path / name)).width() == 40


def test_another_kind_of_file_is_refused(qapp, tmp_path):
    with pytest.raises(InputError, match=r"\.png"):
        write_picture(tmp_path / "a.doc", QPixmap(40, 30))
    assert not list(tmp_path.iterdir())


def test_a_picture_for_which_there_is_no_room_is_missed_in_words(window, tmp_path, monkeypatch):
    path = tmp_path / "window.png"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, **__: (str(path), ""))
    trigger(window, "picture")
    assert QImage(str(path)).width() == window.grab().width()
    before = path.read_bytes()
    with full_disk(len(before) // 2):
        trigger(window, "picture")
    assert path.read_bytes() == before
    assert "could not be written" in window.messages.message.sentence()
