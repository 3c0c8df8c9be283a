"""Second step: frame rate, the frames of the same instant, and the unit of depth."""

from dataclasses import replace

from PySide6.QtWidgets import QCheckBox, QFormLayout, QWizardPage

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import GUESS, Choices, doubts_about
from stereotrack_core.recording.importing.synchronise import (
    METHODS,
    Lead,
    at_one_rate,
    synchronised,
)

from ....services.failures import message_of
from ....services.tasks.task import Task, TaskList
from ....widgets.forms.form_dialog import push_button, say_in
from ....widgets.forms.numbers import NumberField
from ....widgets.style.building import choice, hbox, label, label_of, vbox
from .sources_page import Looked

_WORDS = (
    "Frame k of every source must show the same instant. Where the cameras were started one after "
    "the other, let the offsets be estimated."
)


class TimingPage(QWizardPage):
    """Frames per second, offsets between sources, and metres per count."""

    def __init__(self, looked: Looked, tasks: TaskList) -> None:
        super().__init__()
        self.setTitle("Timing")
        self._choices, self._tasks = looked.proposed, tasks
        self._work: Task | None = None
        self._leads: dict[str, float] = {}
        self.fps = NumberField(
            digits=3, maximum=1000.0, specialValueText="not known",
            accessibleName="Frames per second",
            toolTip="Frame sets per second, as stated by the files",
        )  # fmt: skip
        self.fps.show_stored(looked.found.fps or 0.0)
        self.method = choice(
            "Synchronise by", [("", "nothing: frame 0 of all"), *METHODS.items()],
            "What tells which frames show the same instant",
        )  # fmt: skip
        self.estimate = push_button(
            "&Estimate", self._estimate, "Read the sources and estimate their offsets"
        )
        self.unit = NumberField(
            digits=3, per_unit=1000.0, minimum=0.01, maximum=1000.0, suffix=" mm",
            accessibleName="Depth unit", toolTip="Millimetres per count of the depth maps",
        )  # fmt: skip
        self.unit.show_stored(looked.proposed.depth_unit)
        self.distance, self._middle = label("", "muted"), looked.middle_m
        self.unit.valueChanged.connect(self._say_distance)
        self._say_distance()
        self.resample = QCheckBox("&Resample sources of another or an uneven frame rate")
        self.resample.setChecked(True)
        self.resample.setToolTip(
            "They are written again, each frame the nearest in time. Otherwise frame k of every "
            "source is taken for the same instant."
        )
        self.offsets, self.words = label("", "muted"), label()
        form = self._form(looked)
        self.setLayout(vbox(label(_WORDS, "muted"), form, self.words, None))
        for changed in (
            self.fps.valueChanged, self.method.currentIndexChanged, self.resample.toggled,
        ):  # fmt: skip
            changed.connect(self._forget)

    def _form(self, looked: Looked) -> QFormLayout:
        form = QFormLayout()
        form.addRow("&Frames per second", self.fps)
        form.addRow(label_of(self.method, "&Synchronise by"), hbox((self.method, 1), self.estimate))
        form.addRow("", self.offsets)
        form.addRow("", self.resample)
        if any(source.kind == "depth" for source in looked.found.sources):
            form.addRow("&Depth unit", self.unit)
            form.addRow("", self.distance)
        return form

    def begin(self, choices: Choices) -> None:
        if choices.used() != self._choices.used():
            self._choices = choices
            self._forget()
        self._say()

    def chosen(self, choices: Choices) -> Choices:
        uses = tuple(
            replace(use, lead=self._leads.get(use.source.name, 0.0)) for use in choices.uses
        )
        fps, unit = self.fps.stored() or None, self.unit.stored()
        return replace(
            choices, uses=uses, fps=fps, depth_unit=unit, resample=self.resample.isChecked()
        )

    def timed(self, choices: Choices) -> Choices:
        """The choices at one rate. Raises InputError if the sources have no time in common."""
        return at_one_rate(self.chosen(choices))

    def isComplete(self) -> bool:
        estimated = not self.method.currentData() or bool(self._leads)
        return self.fps.value() > 0 and estimated and not self._doubts()[1]

    def stop(self) -> None:
        if self._work is not None:
            self._work.cancel()
            self._work = None

    def _say_distance(self) -> None:
        metres = self._middle * self.unit.stored()
        self.distance.setText(
            f"Guessed from the scene, whose middle is then {metres:.1f} m away. Check it."
        )

    def _forget(self) -> None:
        """Offsets of other settings are not kept."""
        self.stop()
        self._leads = {}
        self.offsets.clear()
        self._say()

    def _say(self, problem: str = "") -> None:
        self.estimate.setEnabled(bool(self.method.currentData()) and self.fps.value() > 0)
        if self.fps.value() <= 0:
            problem = "The files do not state their frame rate. Enter it."
        doubts, together = self._doubts()
        problem = problem or together
        if problem or self.isComplete():
            say_in(self.words, problem or "\n".join(doubts), error=bool(problem))
        else:
            say_in(self.words, "Press Estimate to find the offsets.")
        self.completeChanged.emit()

    def _doubts(self) -> tuple[list[str], str]:
        """Doubts about timing, and why the sources cannot be combined."""
        try:
            choices = self.timed(self._choices)
        except InputError as error:
            return [], str(error)
        return [one for one in doubts_about(choices) if one != GUESS], ""

    def _estimate(self) -> None:
        choices, method = self.timed(self._choices), self.method.currentData()
        self._forget()
        self.estimate.setEnabled(False)

        def work(task: Task) -> tuple[Choices, tuple[Lead, ...]]:
            return synchronised(
                choices, method, on_progress=task.report, cancelled=task.token.cancelled
            )

        self._work = self._tasks.begin(
            "synchronising the sources", work, self._on_found, self._on_failed
        )
        self._work.progressed.connect(self._on_progress)

    def _on_progress(self, _share: float, words: str) -> None:
        if self.sender() is self._work:
            say_in(self.words, words)

    def _on_found(self, found: tuple[Choices, tuple[Lead, ...]]) -> None:
        if self.sender() is not self._work:  # other settings since
            return
        self._work = None
        choices, leads = found
        self._leads = {use.source.name: use.lead for use in choices.used()}
        self.offsets.setText("\n".join(lead.says(self.fps.stored()) for lead in leads))
        self._say()

    def _on_failed(self, error: Exception) -> None:
        if self.sender() is not self._work:
            return
        self._work = None
        self._say(message_of(error).sentence())
