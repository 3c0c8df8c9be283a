"""What all sources show at one instant, so that a person sees whether they are synchronised."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
from PySide6.QtCore import Qt, Slot
from PySide6.QtGui import QImage, QPixmap, QTransform
from PySide6.QtWidgets import QGridLayout, QLabel, QSlider, QWidget

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.importing.choices import Choices, Use
from stereotrack_core.recording.importing.proposing import possible_units, propose
from stereotrack_core.recording.importing.readers import (
    depth_range,
    first_picture,
    open_source,
    shown_depth,
)
from stereotrack_core.recording.importing.source import Source
from stereotrack_core.recording.importing.sources import Found, look_at

from ....services.tasks.newest import LatestOnly
from ....widgets.style.building import hbox, label, scrolled, vbox


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


_WIDTH, _HEIGHT = 200, 150
_MOST = 8  # sources that are shown
_IN_A_ROW = 4

Question: TypeAlias = tuple[tuple[Use, ...], int]
"""The sources that are used, and the frame of the recording."""


class SyncPreview(QWidget):
    """One picture of each source at the same instant, and a slider over the instants."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._uses: tuple[Use, ...] = ()
        self._fps = 1.0
        self._pictures: dict[str, QLabel] = {}
        self._reading = LatestOnly(lambda question: pictures_at(*question), "preview")
        self._reading.answered.connect(self._show)
        self._grid = QGridLayout()
        inside = QWidget()
        inside.setLayout(self._grid)
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setAccessibleName("Instant of the preview")
        self.slider.setToolTip("Frame of the recording that the pictures show")
        self.slider.valueChanged.connect(self._ask)
        self.when = label("", "muted")
        self.when.setMinimumWidth(130)
        row = hbox((self.slider, 1), self.when)
        self.setLayout(vbox((scrolled(inside, "Preview"), 1), row))

    def show_choices(self, choices: Choices) -> None:
        """Show these sources by their leads; nothing where there is only one."""
        uses = choices.used()[:_MOST]
        self.setVisible(len(uses) > 1)
        if len(uses) < 2 or choices.fps is None or uses == self._uses:
            return
        if [one.source.name for one in uses] != list(self._pictures):
            self._name(uses)
        self._uses, self._fps = uses, choices.fps
        self.slider.setRange(0, max(common_frames(uses) - 1, 0))
        self._ask()

    def close_reading(self) -> None:
        """Read no longer."""
        self._reading.close()

    def settled(self) -> bool:
        """Whether the pictures are those of the slider's frame."""
        return self._reading.settled()

    def shown(self, name: str) -> ImageArray | None:
        """What was read of a source last, for those who look closely."""
        found: ImageArray | None = self._pictures[name].property("pixels")
        return found

    def _name(self, uses: tuple[Use, ...]) -> None:
        while self._grid.count():
            item = self._grid.takeAt(0)
            widget = None if item is None else item.widget()
            if widget is not None:
                widget.deleteLater()
        self._pictures = {}
        for place, use in enumerate(uses):
            row, column = divmod(place, _IN_A_ROW)
            picture = QLabel()
            picture.setMinimumSize(_WIDTH, _HEIGHT)
            picture.setAccessibleName(f"Preview of {use.source.name}")
            self._pictures[use.source.name] = picture
            self._grid.addWidget(picture, 2 * row, column)
            self._grid.addWidget(label(use.source.name, "muted", wraps=False), 2 * row + 1, column)
        self._grid.setRowStretch(2 * len(uses), 1)  # names stay below their pictures

    @Slot()
    def _ask(self) -> None:
        if self._uses:
            frame = self.slider.value()
            self.when.setText(f"frame {frame}, {frame / self._fps:.2f} s")
            self._reading.ask((self._uses, frame))

    @Slot(object, object)
    def _show(self, question: Question, pictures: Mapping[str, ImageArray]) -> None:
        if question[0] != self._uses:
            return
        for use in self._uses:
            name = use.source.name
            found = pictures.get(name)
            self._pictures[name].setPixmap(thumbnail(use.source, found, _WIDTH, _HEIGHT))
            self._pictures[name].setProperty("pixels", found)


def common_frames(uses: tuple[Use, ...]) -> int:
    """Number of frames that all sources show, as far as their headers state it."""
    earliest = min(use.lead for use in uses)
    lengths = []
    for use in uses:
        source = use.source
        frames = float(source.frames)
        if source.rate is not None:
            frames = (source.frames / (source.fps or source.rate) - source.begin) * source.rate
        lengths.append(frames - (use.lead - earliest))
    return max(int(min(lengths)), 1)


def pictures_at(uses: tuple[Use, ...], frame: int) -> dict[str, ImageArray]:
    """What each source shows in a frame of the recording, by its name; none where it is damaged."""
    earliest = min(use.lead for use in uses)
    found: dict[str, ImageArray] = {}
    for use in uses:
        depth = use.role == "depth"
        try:
            reader = open_source(use.source, "depth" if depth else "colour")
        except InputError:
            continue
        try:
            own = round(use.lead - earliest + frame)
            picture = reader.read(own, lambda _number, _picture: None)
        except DamagedFrame:
            continue
        finally:
            reader.close()
        if depth:
            picture = shown_depth(picture, depth_range(picture))
        found[use.source.name] = np.ascontiguousarray(picture[:, ::-1] if use.mirrored else picture)
    return found
