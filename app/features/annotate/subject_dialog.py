"""Enter the subject's lengths, measure them from clicks, keep them in a file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from stereotrack_core.annotation.click_points import MeasuredLength, lengths_of_clicks, subject_of
from stereotrack_core.body.proportions import AVERAGE, proportions_of
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.entries import choose, use_subject
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import SUBJECT
from stereotrack_core.recording.description import LENGTHS, Subject, read_subject, write_subject

from ...session.jobs import Job, TaskList
from ...widgets.forms.form_dialog import (
    FormDialog,
    ask_to_open,
    ask_to_save,
    line_edit,
    push_button,
)
from ...widgets.forms.numbers import NumberField
from ...widgets.style.building import hbox, label, label_of

_FILES = "Subject (*.toml)"
_DIVIDED = (
    "The distance from elbow to hand is divided between forearm and hand as in an average arm."
)
_LENGTHS: Mapping[str, tuple[str, str]] = {
    "shoulder_width": ("Shoulder width", "between the joint centres of both shoulders"),
    "hip_width": ("Hip width", "between the joint centres of both hips"),
    "torso_length": ("Torso", "from the middle of the hips to the middle of the shoulders"),
    "upper_arm_length": ("Upper arm", "from shoulder to elbow"),
    "forearm_length": ("Forearm", "from elbow to wrist"),
    "hand_length": ("Hand", "from the wrist to the tip of the middle finger"),
    "shoulder_to_head": ("Head", "from the middle of the shoulders to the head's landmark"),
}

_LEAST, _MOST = 0.5, 1.8
"""Against an average person of the same size; what lies outside is probably a slip."""


@dataclass(frozen=True, eq=False)
class _Measured:
    """Lengths from clicks: as a subject without a name, and as they were measured."""

    subject: Subject
    lengths: Mapping[str, MeasuredLength]

    def words(self, key: str) -> str:
        length = getattr(self.subject, key)
        if length is None:
            return ""
        shared = key in ("forearm_length", "hand_length")
        own = self.lengths["elbow_to_hand" if shared else key]
        return f"{1000 * length:.0f} ± {1000 * own.sigma:.0f} mm, {own.count} samples"


class SubjectDialog(FormDialog):
    """The name and the lengths of the subject that the project uses.

    `recorded` is the subject of the recording's folder.
    """

    def __init__(
        self,
        project: Project,
        cameras: Mapping[str, Camera],
        recorded: Subject | None,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Subject", "&Use", self._use, parent, close=True)
        self._project, self._cameras, self._tasks = project, cameras, tasks
        self._recorded = recorded or Subject()
        self._measured: _Measured | None = None
        self._offsets = self._recorded.offsets
        self.name = line_edit("Name", placeholder="Name of the subject")
        self.lengths: dict[str, NumberField] = {}
        self._averages: dict[str, QLabel] = {}
        self._found: dict[str, QLabel] = {}
        self._lay_out_parts()
        self.name.textChanged.connect(self._check)
        self.show_subject(project.subject() or self._recorded)

    def _lay_out_parts(self) -> None:
        self.measure_button = push_button("&Measure from clicks", self._measure)
        self.take_button = push_button("Use &measured lengths", self._take_measured)
        self.take_button.setEnabled(False)
        ask = partial(ask_to_open, self, "Load a subject", "", _FILES, self.load)
        load_button = push_button("&Load …", ask)
        self.store_button = push_button("Save as &file …", self._ask_to_store)
        again = partial(self.show_subject, self._recorded)
        self.recorded_button = push_button("As in the &recording", again)
        kept = hbox(self.recorded_button, load_button, self.store_button, None)
        measured = hbox(self.measure_button, self.take_button, None)
        name = hbox(label_of(self.name, "&Name"), self.name)
        self.lay_out(name, kept, self._form(), measured, None, size=(560, 420))

    def _form(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setHorizontalSpacing(14)
        for column, heading in enumerate(("", "Length", "Average", "Measured from clicks")):
            grid.addWidget(label(heading, "muted", wraps=False), 0, column)
        for row, (key, (name, between)) in enumerate(_LENGTHS.items(), start=1):
            box = NumberField(
                digits=0, per_unit=1000.0, maximum=1500.0, suffix=" mm",
                specialValueText="not measured", accessibleName=name,
                toolTip=f"In millimetres, {between}; 0: not measured",
            )  # fmt: skip
            box.setMinimumWidth(box.fontMetrics().horizontalAdvance("not measured") + 44)
            box.valueChanged.connect(self._check)
            named = label_of(box, name)
            named.setToolTip(between)
            average, found = label("", "muted", wraps=False), label(wraps=False)
            for column, widget in enumerate((named, box, average, found)):
                grid.addWidget(widget, row, column)
            self.lengths[key], self._averages[key], self._found[key] = box, average, found
        grid.setColumnStretch(3, 1)
        return grid

    # ---- what is shown

    def draft(self) -> Subject:
        lengths = {key: box.stored() or None for key, box in self.lengths.items()}
        known: dict[str, Any] = {**lengths, "offsets": self._offsets}
        return Subject(self.name.text().strip(), **known)

    def show_subject(self, subject: Subject) -> None:
        self._offsets = subject.offsets
        self.name.setText(subject.name)
        for key, box in self.lengths.items():
            box.show_stored(getattr(subject, key) or 0.0)
        self._check()

    def _check(self) -> None:
        draft = self.draft()
        average = _average_of(draft)
        for key, shown in self._averages.items():
            shown.setText(f"{1000 * average[key]:.0f} mm")
        doubts = _doubts_about(draft, average)
        unnamed = not draft.name and self._differs(draft)
        hint = "Name the subject to keep these lengths." if unnamed else ""
        self.say("\n".join(doubts) or hint, error=bool(doubts))
        self.accept_button.setEnabled(not self._project.read_only and not unnamed)
        self.store_button.setEnabled(bool(draft.name))

    def _differs(self, draft: Subject) -> bool:
        return draft != replace(self._recorded, name=draft.name and self._recorded.name)

    # ---- what is done

    def _measure(self) -> None:
        project, cameras = self._project, self._cameras

        def work(_task: object) -> _Measured | InputError:
            names = project.landmark_set().names
            try:
                found = lengths_of_clicks(project.clicks.used(), cameras, names, project.path.name)
            except InputError as error:
                return error
            return _Measured(subject_of("", found), found)

        self.measure_button.setEnabled(False)
        self._tasks.run(Job("measuring segment lengths", work, self._on_measured))

    def _on_measured(self, found: _Measured | InputError) -> None:
        self.measure_button.setEnabled(True)
        if isinstance(found, InputError):
            self.say(str(found), error=True)
            return
        self._measured = found
        for key, shown in self._found.items():
            shown.setText(found.words(key))
        self.take_button.setEnabled(True)
        self.say(_DIVIDED)

    def _take_measured(self) -> None:
        if self._measured is not None:
            known = {key: getattr(self._measured.subject, key) for key in self.lengths}
            taken = {key: value for key, value in known.items() if value is not None}
            self.show_subject(replace(self.draft(), **taken))

    def _use(self) -> None:
        draft = self.draft()

        def use() -> None:
            if self._differs(draft):
                self._project.apply(use_subject(draft, self._origin(draft)))
            elif self._project.chosen(self._project.subjects) is not None:
                self._project.apply(choose(SUBJECT, None))

        if self.attempt(use):
            self.accept()

    def _origin(self, draft: Subject) -> str:
        if self._measured is None:
            return "entered"
        both = [(getattr(self._measured.subject, k), getattr(draft, k)) for k in self.lengths]
        same = all(a is None or (b is not None and abs(a - b) < 0.001) for a, b in both)
        return "measured from clicks" if same else "entered"

    def load(self, path: Path) -> None:
        def load() -> None:
            subject = read_subject(path)
            self.show_subject(replace(subject, name=subject.name or path.stem))

        self.attempt(load)

    def _ask_to_store(self) -> None:
        name = f"{self.draft().name or 'subject'}.toml"
        ask_to_save(self, "Save the subject", name, _FILES, self.store)

    def store(self, path: Path) -> None:
        path = path if path.suffix else path.with_suffix(".toml")
        if self.attempt(lambda: write_subject(path, self.draft())):
            self.say(f"Saved to {path}.")


def _average_of(subject: Subject) -> dict[str, float]:
    """Lengths in metres that an average person of this one's size has."""
    whole, average = asdict(proportions_of(subject)), asdict(AVERAGE)
    known = [key for key in LENGTHS if getattr(subject, key) is not None] or LENGTHS
    scale = sum(whole[key] for key in known) / sum(average[key] for key in known)
    return {key: scale * average[key] for key in LENGTHS}


def _doubts_about(subject: Subject, average: Mapping[str, float]) -> list[str]:
    """Lengths that nobody of this size has, in words."""
    said = []
    for key in LENGTHS:
        length = getattr(subject, key)
        if length is not None and not _LEAST < length / average[key] < _MOST:
            said.append(
                f"{_LENGTHS[key][0]}: {1000 * length:.0f} mm; a person of this size has about "
                f"{1000 * average[key]:.0f} mm. Measure it again."
            )
    return said
