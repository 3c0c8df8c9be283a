"""The steps from videos to a recording; the second: frame rate, instants, unit of depth."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QFormLayout, QWidget, QWizard, QWizardPage

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import GUESS, Choices, doubts_about
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.readers import with_one_white
from stereotrack_core.recording.importing.synchronise import (
    METHODS,
    Lead,
    at_one_rate,
    synchronised,
)

from ....session.jobs import Job, NewestJob, Task, TaskList
from ....session.messages import message_of
from ....widgets.forms.form_dialog import push_button, say_in
from ....widgets.forms.numbers import NumberField, refusal_in
from ....widgets.style.building import choice, hbox, label, label_of, vbox
from .calibration_page import CalibrationPage
from .sources_page import Looked, PlacePage, SourcesPage

_WORDS = (
    "Frame k of every source must show the same instant. Where the cameras were started one after "
    "the other, let the offsets be estimated."
)


class TimingPage(QWizardPage):
    """Frames per second, offsets between sources, and metres per count."""

    def __init__(self, looked: Looked, tasks: TaskList) -> None:
        super().__init__()
        self.setTitle("Timing")
        self._choices, self._work = looked.proposed, NewestJob(tasks)
        self.stop = self._work.give_up
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
        tip = "Read the sources and estimate their offsets"
        self.estimate = push_button("&Estimate", self._estimate, tip)
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
        self.setLayout(vbox(label(_WORDS, "muted"), self._form(looked), self.words, None))
        self.fps.valueChanged.connect(self._forget)
        self.method.currentIndexChanged.connect(self._forget)
        self.resample.toggled.connect(self._forget)

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
        leads = [(use, self._leads.get(use.source.name, 0.0)) for use in choices.uses]
        return replace(
            choices, uses=tuple(replace(use, lead=lead) for use, lead in leads),
            fps=self.fps.stored() or None, depth_unit=self.unit.stored(),
            resample=self.resample.isChecked(),
        )  # fmt: skip

    def isComplete(self) -> bool:
        estimated = not self.method.currentData() or bool(self._leads)
        return self.fps.value() > 0 and estimated and not self._doubts()[1]

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
            choices = at_one_rate(self.chosen(self._choices))
        except InputError as error:
            return [], str(error)
        return [one for one in doubts_about(choices) if one != GUESS], ""

    def _estimate(self) -> None:
        choices, method = at_one_rate(self.chosen(self._choices)), self.method.currentData()
        self._forget()
        self.estimate.setEnabled(False)

        def work(task: Task) -> tuple[Choices, tuple[Lead, ...]]:
            return synchronised(choices, method, task.work)

        self._work.run(Job(
            "synchronising the sources", work, self._on_found,
            lambda error: self._say(message_of(error).sentence()),
            progressed=lambda _share, words: say_in(self.words, words),
        ))  # fmt: skip

    def _on_found(self, found: tuple[Choices, tuple[Lead, ...]]) -> None:
        choices, leads = found
        self._leads = {use.source.name: use.lead for use in choices.used()}
        self.offsets.setText("\n".join(lead.says(self.fps.stored()) for lead in leads))
        self._say()


class ImportWizard(QWizard):
    """Sources, timing, calibration, folder; at the end the recording is made.

    Nothing is written before the last step; Cancel while it is written leaves nothing behind.
    `made` is called with the folder of the recording.
    """

    def __init__(
        self,
        looked: Looked,
        tasks: TaskList,
        made: Callable[[Path], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Make a recording")
        self.setWizardStyle(QWizard.WizardStyle.ClassicStyle)
        self.setOption(QWizard.WizardOption.NoBackButtonOnStartPage)
        self._looked, self._made = looked, made
        self._work = NewestJob(tasks)
        self.sources, self.timing = SourcesPage(looked), TimingPage(looked, tasks)
        self.calibration = CalibrationPage(looked.proposed, looked.found.folder)
        self.place = PlacePage(looked)
        self.steps = (self.sources, self.timing, self.calibration, self.place)
        for number, page in enumerate(self.steps, start=1):
            page.setSubTitle(f"Step {number} of {len(self.steps)}")
            self.addPage(page)
        self.setButtonText(QWizard.WizardButton.FinishButton, "&Make recording")
        self.currentIdChanged.connect(self._on_page)
        self.resize(900, 640)

    def choices(self) -> Choices:
        choices = self._looked.proposed
        for page in self.steps:
            choices = page.chosen(choices)
        return with_one_white(at_one_rate(choices))

    def _on_page(self, number: int) -> None:
        page = self.page(number)
        if isinstance(page, TimingPage):
            page.begin(self.sources.chosen(self._looked.proposed))
        elif isinstance(page, CalibrationPage | PlacePage):
            page.begin(self.choices())

    def validateCurrentPage(self) -> bool:
        if refusal := refusal_in(self.timing):
            say_in(self.timing.words, refusal, error=True)
            return False
        return super().validateCurrentPage()

    def accept(self) -> None:
        if self._work.busy:
            return
        choices, folder = self.choices(), self.place.place()
        self._show_working(working=True)

        def work(task: Task) -> Path:
            make_recording(choices, folder, task.work)
            return folder

        self._work.run(Job(
            "making the recording", work, self._on_made,
            lambda error: self._stand_still(message_of(error).sentence(), error=True),
            lambda: self._stand_still("Stopped. No recording was created."),
            progressed=self._on_progress,
        ))  # fmt: skip

    def reject(self) -> None:
        if self._work.busy:
            self._work.cancel()
            return
        self.timing.stop()
        super().reject()

    def _show_working(self, *, working: bool) -> None:
        self.place.progress.setVisible(working)
        self.place.progress.setRange(0, 1000)
        for which in (QWizard.WizardButton.BackButton, QWizard.WizardButton.FinishButton):
            self.button(which).setEnabled(not working)
        for field in (self.place.name, self.place.folder):
            field.setEnabled(not working)

    def _on_progress(self, share: float, words: str) -> None:
        self.place.progress.setValue(round(1000 * share))
        say_in(self.place.words, words)

    def _on_made(self, folder: Path) -> None:
        self.timing.stop()
        super().accept()
        self._made(folder)

    def _stand_still(self, words: str, *, error: bool = False) -> None:
        self._show_working(working=False)
        say_in(self.place.words, words, error=error)
