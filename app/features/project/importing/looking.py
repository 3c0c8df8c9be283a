"""What the wizard begins with, found off the window's thread: sources, pictures, depth unit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPixmap, QTransform

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import Choices
from stereotrack_core.recording.importing.proposing import possible_units, propose
from stereotrack_core.recording.importing.readers import first_picture
from stereotrack_core.recording.importing.source import Source
from stereotrack_core.recording.importing.sources import Found, look_at


@dataclass(frozen=True, eq=False)
class Looked:
    """Sources with their first pictures, and what is proposed to be made of them."""

    found: Found
    proposed: Choices
    pictures: Mapping[str, ImageArray]
    """First picture by the source's name; absent where it cannot be decoded."""
    problems: tuple[InputError, ...]
    """What could not be read."""
    middle_m: float
    """Metres to the middle of the depth scene for each metre of a count; NaN without depth."""
    place: Path
    """Where the recording goes unless the person chooses another folder."""


def look(paths: Sequence[Path]) -> Looked:
    """Look at what was named, read the first pictures, and propose.

    Raises InputError where nothing usable was found.
    """
    found = look_at(paths)
    proposed = propose(found)
    pictures, problems = {}, list(found.problems)
    for use in proposed.uses:
        source = use.source
        try:
            pictures[source.name] = first_picture(source, as_depth=use.role == "depth")
        except InputError as problem:
            problems.append(problem)
    depths = [source for source in found.sources if source.kind == "depth"]
    middle = math.nan
    if depths:
        unit, metres = possible_units(depths[0])[0]
        middle = metres / unit
        proposed = replace(proposed, depth_unit=depths[0].unit or unit)
    return Looked(found, proposed, pictures, tuple(problems), middle, _place(paths, found))


def _place(paths: Sequence[Path], found: Found) -> Path:
    """The folder that was named itself; else a new one beside the files."""
    if found.folder is not None and paths[0].is_dir():
        return found.folder
    parent = found.folder or Path(paths[0]).absolute().parent
    return parent / f"{parent.name or 'videos'}-recording"


def thumbnail(source: Source, picture: ImageArray | None, width: int, height: int) -> QPixmap:
    """A small upright picture of at most so many pixels; a grey one where there is none."""
    if picture is None:
        empty = QPixmap(width, height)
        empty.fill(Qt.GlobalColor.darkGray)
        return empty
    pixels = np.ascontiguousarray(picture)
    form = QImage.Format.Format_Grayscale8 if pixels.ndim == 2 else QImage.Format.Format_BGR888
    image = QImage(pixels.data, pixels.shape[1], pixels.shape[0], pixels.strides[0], form)
    turned = image.transformed(QTransform().rotate(source.turned))
    kept, smooth = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
    return QPixmap.fromImage(turned.scaled(width, height, kept, smooth).copy())
