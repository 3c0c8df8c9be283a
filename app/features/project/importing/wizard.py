"""The steps from videos to a recording."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget, QWizard

from stereotrack_core.recording.importing.choices import Choices
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.readers import with_one_white
from stereotrack_core.recording.importing.synchronise import at_one_rate

from ....context import Context
from ....services.failures import message_of
from ....services.tasks.task import CancelToken, Task, TaskList
from ....session.changes import Part
from ....widgets.forms.form_dialog import ask_for_folder, say_in
from ....widgets.forms.numbers import refusal_in
from ..files import recent_folder
from .calibration_page import CalibrationPage
from .sources_page import Looked, PlacePage, SourcesPage, look
from .timing_page import TimingPage


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
        self._looked, self._tasks, self._made = looked, tasks, made
        self._work: Task | None = None
        self.sources, self.timing = SourcesPage(looked), TimingPage(looked, tasks)
        self.calibration, self.place = CalibrationPage(looked), PlacePage(looked)
        self.steps = (self.sources, self.timing, self.calibration, self.place)
        for page in self.steps:
            page.setSubTitle(f"Step {self.steps.index(page) + 1} of {len(self.steps)}")
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
        if self._work is not None:
            return
        choices, folder = self.choices(), self.place.place()
        self._show_working(working=True)

        def work(task: Task) -> Path:
            make_recording(choices, folder, on_progress=task.report, cancelled=task.token.cancelled)
            return folder

        def failed(error: Exception) -> None:
            self._stand_still(message_of(error).sentence(), error=True)

        self._work = self._tasks.begin("making the recording", work, self._on_made, failed)
        self._work.progressed.connect(self._on_progress)
        stopped = "Stopped. No recording was created."
        self._work.stopped.connect(lambda: self._stand_still(stopped))

    def reject(self) -> None:
        if self._work is not None:
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
        self._work = None
        self.timing.stop()
        super().accept()
        self._made(folder)

    def _stand_still(self, words: str, *, error: bool = False) -> None:
        self._work = None
        self._show_working(working=False)
        say_in(self.place.words, words, error=error)


class ImportController:
    """From dropped videos, or a folder without a recording.toml, to an open recording."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._looking: CancelToken | None = None
        self.wizard: ImportWizard | None = None
        self._opening = context.session.opening
        context.session.changes.hear(Part.IMPORT_WANTED, self.offer)

    def ask_for_videos(self) -> None:
        parent, start = self._context.docks.dialog_parent, recent_folder(self._opening)
        title = "Folder of the videos or images"
        ask_for_folder(parent, title, start, lambda path: self.offer((path,)))

    def offer(self, paths: tuple[Path, ...]) -> None:
        if self.wizard is not None:  # what is being filled in is not thrown away
            self.wizard.raise_()
            return
        self._looking = token = self._context.tasks.begin(
            "looking at the videos",
            lambda _task: look(paths),
            lambda looked: self._show(looked) if token is self._looking else None,
        ).token

    def _show(self, looked: Looked) -> None:
        if self.wizard is not None:
            return
        parent = self._context.docks.dialog_parent
        wizard = ImportWizard(looked, self._context.tasks, self._opening.open, parent)
        wizard.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        wizard.finished.connect(self._on_finished)
        self.wizard = wizard
        wizard.open()

    def _on_finished(self) -> None:
        self.wizard = None
