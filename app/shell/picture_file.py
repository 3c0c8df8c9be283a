"""Pictures of the window as files."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QBuffer, QIODevice
from PySide6.QtGui import QPixmap

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError


def write_picture(path: Path, picture: QPixmap) -> None:
    """Write a picture, by the suffix of the name.

    Raises
    ------
    InputError
        Where the file cannot be written, or Qt writes no pictures of this kind.
    """
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not picture.save(buffer, path.suffix.removeprefix(".")):
        raise InputError(
            "an image cannot be written to this type of file",
            where=str(path),
            remedy="Choose a file name that ends in .png.",
        )
    write_file(path, bytes(buffer.data().data()))
