"""Edit which landmarks are clicked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QSignalBlocker, Slot
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QColorDialog, QWidget

from stereotrack_core.annotation.landmark_set import (
    NINE,
    Landmark,
    LandmarkSet,
    read_landmark_set,
    write_landmark_set,
)
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.pose import PartFrames, hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import LANDMARK_SET
from stereotrack_core.project.setups import load_landmark_set, save_landmark_set

from ....widgets.forms.body_sketch import BodySketch, Sketch
from ....widgets.forms.form_dialog import (
    FormDialog,
    ask_to_open,
    ask_to_save,
    line_edit,
    push_button,
)
from ....widgets.style.building import choice, hbox, label, vbox
from ....widgets.tables.landmark_table import LandmarkTable
from ....widgets.tables.table import selected_rows

_SPREAD_ARMS = 0.6
"""Radians by which the drawn person holds the arms away from the body."""


@dataclass(frozen=True)
class Draft:
    """A set that may not be right yet."""

    name: str
    landmarks: tuple[Landmark, ...]

    def checked(self) -> LandmarkSet:
        """The set; InputError names the landmark that is not usable, and what would be right."""
        return LandmarkSet(self.name.strip(), self.landmarks)

    def problem(self) -> InputError | None:
        """What is wrong, if anything is."""
        try:
            self.checked()
        except InputError as error:
            return error
        return None

    def changed(self, row: int, **values: object) -> Draft:
        """The draft with other values of one landmark; its mirror follows a new name."""
        old = self.landmarks[row]
        new = replace(old, **values)  # type: ignore[arg-type]
        landmarks = [new if i == row else one for i, one in enumerate(self.landmarks)]
        if new.name != old.name:
            landmarks = [
                replace(one, mirror=new.name) if one.mirror == old.name else one
                for one in landmarks
            ]
        elif new.mirror != old.mirror:
            landmarks = [_paired(one, new, old.mirror) for one in landmarks]
        return replace(self, landmarks=tuple(landmarks))

    def added(self) -> Draft:
        """The draft with one more landmark, to be filled in."""
        names = {one.name for one in self.landmarks}
        number = next(i for i in range(1, 1000) if f"landmark_{i}" not in names)
        new = Landmark(f"landmark_{number}", "#CC79A7", "torso", "torso", along=0.5)
        return replace(self, landmarks=(*self.landmarks, new))

    def without(self, rows: Iterable[int]) -> Draft:
        """The draft without these landmarks; who was paired with them is not any more."""
        gone = set(rows)
        names = {one.name for i, one in enumerate(self.landmarks) if i in gone}
        kept = [one for i, one in enumerate(self.landmarks) if i not in gone]
        freed = [replace(one, mirror="") if one.mirror in names else one for one in kept]
        return replace(self, landmarks=tuple(freed))

    def moved(self, row: int, by: int) -> Draft:
        """The draft with a landmark at another place of the order, which is that of the keys."""
        to = row + by
        if not (0 <= row < len(self.landmarks) and 0 <= to < len(self.landmarks)):
            return self
        landmarks = list(self.landmarks)
        landmarks.insert(to, landmarks.pop(row))
        return replace(self, landmarks=tuple(landmarks))


def _paired(one: Landmark, new: Landmark, before: str) -> Landmark:
    """Let the two of a pair name each other, and nobody else name either of them."""
    if one.name == new.name:
        return new
    if new.mirror and one.name == new.mirror:
        return replace(one, mirror=new.name)
    if one.mirror in (new.name, new.mirror) or one.name == before:
        return replace(one, mirror="")
    return one


def sketch_of(landmarks: Sequence[Landmark]) -> Sketch:
    """A person seen from the front, with the landmarks that have a place on the body."""
    body = body_model(AVERAGE)
    pose = hanging_pose(np.zeros(3))
    turned = pose.rotations.copy()
    for part, sign in ((2, 1.0), (3, -1.0), (4, 1.0), (5, -1.0)):
        turned[part] = rotation_from_vector(np.array([0, sign * _SPREAD_ARMS, 0])) @ turned[part]
    frames = body.frames(replace(pose, rotations=turned))
    usable = [one for one in landmarks if _has_place(one)]
    dots: tuple[tuple[float, float, str, str], ...] = ()
    if usable:
        places = _unchecked(usable).places(body, frames)
        dots = tuple(
            (*_seen(place), one.colour, one.label)
            for place, one in zip(places, usable, strict=True)
        )
    return Sketch(_lines(body, frames), dots)


def _has_place(landmark: Landmark) -> bool:
    try:
        LandmarkSet("one", (replace(landmark, mirror=""),))
    except InputError:
        return False
    return True


def _unchecked(landmarks: Sequence[Landmark]) -> LandmarkSet:
    """A set of landmarks whose names and mirrors do not matter."""
    renamed = (replace(one, name=f"l{i}", mirror="") for i, one in enumerate(landmarks))
    return LandmarkSet("sketch", tuple(renamed))


def _lines(
    body: BodyModel, frames: PartFrames
) -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
    ends = []
    for part in range(len(LIMBS)):
        origin = frames.origins[part]
        tip = origin + frames.rotations[part][:, 2] * body.skeleton.lengths[part]
        ends.append((_seen(origin), _seen(tip)))
    half_hips = np.array([0.5 * AVERAGE.hip_width, 0.0, 0.0])
    ends.append((_seen(-half_hips), _seen(half_hips)))
    ends.append((_seen(frames.origins[2]), _seen(frames.origins[3])))
    return tuple(ends)


def _seen(point: FloatArray) -> tuple[float, float]:
    """Right and down of a viewer in front: the person's right is at the viewer's left."""
    return -float(point[0]), -float(point[2])


_FILES = "Set of landmarks (*.toml)"


class LandmarkSetDialog(FormDialog):
    """A table of the landmarks beside a body that shows where they are."""

    def __init__(self, project: Project, parent: QWidget | None = None) -> None:
        super().__init__("Landmark set", "Use", self._use, parent)
        self._project, self._sets = project, project.landmark_sets
        self._clicked = Counter(one.landmark for one in project.clicks.seen())
        self.draft = self._stored(project.landmark_set().name)
        """The set as it is written in the table."""
        self.choice = choice("Landmark sets of the project")
        self.name = line_edit(
            "Name of the landmark set", tip="A new name creates a new set; the old one is kept."
        )
        self.table = LandmarkTable()
        self.table.rows_model.editable = not project.read_only
        self.sketch, self.warning = BodySketch(), label("", "muted")
        self._lay_out_parts()
        names = self._sets.names()
        with QSignalBlocker(self.choice):
            self.choice.addItems([*(() if NINE.name in names else (NINE.name,)), *names])
            self.choice.setCurrentText(self.draft.name)
        self.choice.currentTextChanged.connect(lambda name: self.show_draft(self._stored(name)))
        self.name.textEdited.connect(
            lambda name: self.show_draft(Draft(name, self.draft.landmarks))
        )
        self.table.rows_model.edited.connect(self._on_edited)
        self.table.colour_requested.connect(self._ask_for_colour)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._draw())
        self.show_draft(self.draft)

    def _lay_out_parts(self) -> None:
        self.add_button = push_button("&Add", lambda: self.show_draft(self.draft.added()))
        self.remove_button = push_button("&Remove", self._remove)
        self.up_button = push_button("&Up", lambda: self._move(-1))
        down_button = push_button("D&own", lambda: self._move(1))
        ask = partial(ask_to_open, self, "Import landmark set", "", _FILES, self.load)
        load_button = push_button("&Import …", ask)
        self.store_button = push_button("&Export …", self._ask_to_store)
        editing = (self.add_button, self.remove_button, self.up_button, down_button)
        for button in editing:
            button.setEnabled(not self._project.read_only)
        sets = hbox(label("Set", wraps=False), self.choice)
        named = hbox(label("Name", wraps=False), (self.name, 1), load_button, self.store_button)
        rows = vbox((self.table, 1), hbox(*editing, None))
        self.lay_out(
            hbox(sets, (named, 1), spacing=12),
            (hbox((rows, 1), self.sketch), 1),
            self.warning,
            size=(1230, 520),
        )

    def _stored(self, name: str) -> Draft:
        landmarks = load_landmark_set(self._sets, name)
        return Draft(landmarks.name, landmarks.landmarks)

    def show_draft(self, draft: Draft) -> None:
        """Show a set, and say what is wrong about it."""
        self.draft = draft
        problem = draft.problem()
        wrong = -1 if problem is None else self._row_of(problem)
        self.table.rows_model.show_landmarks(draft.landmarks, wrong)
        if self.name.text() != draft.name:
            self.name.setText(draft.name)
        count = len(draft.landmarks)
        many = f"The keys 1 to 9 choose the first nine of {count} landmarks." if count > 9 else ""
        self.say(many if problem is None else str(problem), error=problem is not None)
        self.warning.setText(self._not_shown())
        self.warning.setVisible(bool(self.warning.text()))
        self.accept_button.setEnabled(problem is None and not self._project.read_only)
        self.store_button.setEnabled(problem is None)
        self._draw()

    def _row_of(self, problem: InputError) -> int:
        names = [one.name for one in self.draft.landmarks]
        named = problem.where.rpartition(", ")[2]
        if named in names:
            return names.index(named)
        twice = [name for name in names if names.count(name) > 1]
        return names.index(twice[0]) if twice else -1

    def _not_shown(self) -> str:
        """Which clicks would not be shown any more, in words; empty where all would be."""
        names = {one.name for one in self.draft.landmarks}
        said = ", ".join(
            f"{name.replace('_', ' ')} (in {counted(count, 'frame')})"
            for name, count in sorted(self._clicked.items())
            if name not in names
        )
        kept = "These clicks are kept but not shown."
        return f"Clicked but not in this landmark set: {said}. {kept}" if said else ""

    def _draw(self) -> None:
        rows = selected_rows(self.table)
        chosen = self.draft.landmarks[rows[0]].label if rows else ""
        self.sketch.show_sketch(sketch_of(self.draft.landmarks), chosen)
        self.remove_button.setEnabled(bool(rows) and not self._project.read_only)

    # ---- what is done

    @Slot(int, str, object)
    def _on_edited(self, row: int, field: str, value: object) -> None:
        self.show_draft(self.draft.changed(row, **{field: value}))

    def _remove(self) -> None:
        self.show_draft(self.draft.without(selected_rows(self.table)))

    def _move(self, by: int) -> None:
        rows = selected_rows(self.table)
        if len(rows) == 1:
            self.show_draft(self.draft.moved(rows[0], by))
            self.table.selectRow(min(max(rows[0] + by, 0), len(self.draft.landmarks) - 1))

    @Slot(int)
    def _ask_for_colour(self, row: int) -> None:
        dialog = QColorDialog(QColor(self.draft.landmarks[row].colour), self)
        dialog.colorSelected.connect(lambda colour: self._on_edited(row, "colour", colour.name()))
        dialog.open()

    def _use(self) -> None:
        def use() -> None:
            landmarks = self.draft.checked()
            chosen: str | None = landmarks.name
            if landmarks == NINE and NINE.name not in self._sets.names():
                chosen = None
            else:
                self._project.apply(save_landmark_set(landmarks))
            if self._project.chosen(self._sets) != chosen:
                self._project.apply(Choose(LANDMARK_SET.name, chosen))

        if self.attempt(use):
            self.accept()

    def load(self, path: Path) -> None:
        """Show the set of a file; nothing is kept before it is used."""

        def load() -> None:
            landmarks = read_landmark_set(path)
            self.show_draft(Draft(landmarks.name, landmarks.landmarks))

        self.attempt(load)

    def _ask_to_store(self) -> None:
        name = f"{self.draft.name or 'landmarks'}.toml"
        ask_to_save(self, "Export landmark set", name, _FILES, self.store)

    def store(self, path: Path) -> None:
        """Write the set to a file."""
        path = path if path.suffix else path.with_suffix(".toml")
        if self.attempt(lambda: write_landmark_set(path, self.draft.checked())):
            self.say(f"Saved to {path}.")
