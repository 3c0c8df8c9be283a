"""Calibrate from the person: asks for a length, calculates beside the window, and says how well."""

from functools import partial

from PySide6.QtWidgets import QFormLayout

from stereotrack_core.annotation.click import UNCERTAIN, Visibility
from stereotrack_core.calibrate.person import (
    KnownLength,
    PersonCalibration,
    calibrate_from_person,
)
from stereotrack_core.errors import InputError

from ...context import Context
from ...session.changes import PROJECT, RECORDING
from ...session.jobs import Job, NewestJob
from ...session.replacing import replace_cameras
from ...session.session import unless
from ...widgets.forms.form_dialog import FormDialog
from ...widgets.forms.numbers import NumberField
from ...widgets.style.building import choice, label

_ABOUT = (
    "Cameras are calculated from clicks of the same landmarks in several views, in frames in which "
    "the person reaches differently. A length gives the scale. All cameras have one zoom; if you "
    "know its focal length, fewer clicks do."
)


class PersonDialog(FormDialog):
    """Two landmarks, the length between them, and the focal length if it is known."""

    def __init__(self, calibrator: "PersonCalibrator", names: tuple[str, ...]) -> None:
        parent = calibrator.context.docks.dialog_parent
        super().__init__("Calibrate from the person", "Calibrate", self._on_button, parent)
        self._calibrator, self._job = calibrator, NewestJob(calibrator.context.tasks)
        self._found: PersonCalibration | None = None
        options = [(name, name.replace("_", " ")) for name in names]
        self.ends = [choice(f"{nth} landmark", options, "An end of the length") for nth in _ENDS]
        for box, name in zip(self.ends, ("left_shoulder", "right_shoulder"), strict=True):
            box.setCurrentIndex(max(box.findData(name), 0))
        self.length = NumberField(minimum=0.0, maximum=3000.0, singleStep=5.0, suffix=" mm")
        self.focal = NumberField(minimum=0.0, maximum=50000.0, singleStep=10.0, suffix=" px")
        form = QFormLayout()
        rows = ("&From", self.ends[0]), ("&To", self.ends[1]), ("&Length", self.length)
        for name, field in (*rows, ("F&ocal length, 0: find it", self.focal)):
            field.setAccessibleName(name.replace("&", ""))
            form.addRow(name, field)
        for number in (self.length, self.focal):
            number.valueChanged.connect(self._forget)
        for box in self.ends:
            box.currentIndexChanged.connect(self._forget)
        self.finished.connect(self._job.give_up)
        self.lay_out(label(_ABOUT), form, None, size=(460, 340))

    def _forget(self) -> None:
        self._job.give_up()
        self._found = None
        self.accept_button.setText("Calibrate")
        self.accept_button.setEnabled(True)
        self.say("")

    def _on_button(self) -> None:
        found = self._found
        if found is not None:
            if self.attempt(lambda: self._calibrator.use(found)):
                self.accept()
            return
        ends = [str(box.currentData()) for box in self.ends]
        length = KnownLength(ends[0], ends[1], self.length.stored() / 1000.0)
        if not length.metres or ends[0] == ends[1]:
            self.say("Choose two landmarks, and type the length between them.", error=True)
            return
        self.say("Calculating …")
        self.accept_button.setEnabled(False)
        job = self._calibrator.job(length, self.focal.stored())
        self._job.run(Job(job.title, job.work, self._on_found, self._on_failed))

    def _on_found(self, found: PersonCalibration) -> None:
        self._found = found
        self.accept_button.setText("Use these cameras")
        self.accept_button.setEnabled(True)
        self.say(found.words())

    def _on_failed(self, error: Exception) -> None:
        self._forget()
        if isinstance(error, InputError):
            self.say(str(error), error=True)
        else:
            self._calibrator.context.notifier.error(error)


_ENDS = ("First", "Second")


class PersonCalibrator:
    """Calculates the cameras of a recording of guessed ones from its project's clicks."""

    def __init__(self, context: Context) -> None:
        self.context, self._session = context, context.session
        self._dialog: PersonDialog | None = None
        context.session.changes.watch(PROJECT | RECORDING, self._close)

    def why_not(self) -> str:
        recording = self._session.document.recording
        if recording is None or self._session.no_project():
            return self._session.no_project()
        known = "The cameras of the recording are known. Attach a calibration to replace them."
        alone = all(view.kind == "mono" for view in recording.views) and len(recording.views) > 1
        two = "This needs two ordinary cameras or more, and no stereo cameras."
        return unless(recording.guessed, known) or unless(alone, two)

    def ask(self) -> None:
        project = self._session.project.project
        if project is None or self.why_not():
            return
        self._dialog = PersonDialog(self, project.landmark_set().names)
        self._dialog.finished.connect(self._forget)
        self._dialog.open()

    def job(self, length: KnownLength, focal: float) -> Job:
        """The calculation; a focal length of 0 pixels is found."""
        recording, project = self._session.document.recording, self._session.project.project
        assert recording is not None and project is not None  # noqa: S101, PT018 - it was asked
        cameras = [recording.reference_camera(view) for view in recording.views]
        sizes = {one.name: (one.width, one.height) for one in cameras}
        share = focal / max(max(size) for size in sizes.values()) or None
        clicks: dict[tuple[int, str], dict[str, tuple[float, float]]] = {}
        for one in project.clicks.all():
            sure = one.visibility == Visibility.SEEN and one.flag != UNCERTAIN
            if sure and one.position is not None:
                clicks.setdefault((one.frame, one.landmark), {})[one.camera] = one.position
        work = partial(calibrate_from_person, clicks, sizes, length, share)
        return Job("calibrating from the person", lambda task: work(task.work))

    def use(self, found: PersonCalibration) -> None:
        """Give the recording the cameras. Raises InputError."""
        what = f"The cameras are calibrated. {found.words()}"
        replace_cameras(self._session, found.cameras, what)

    def _forget(self) -> None:
        self._dialog = None

    def _close(self) -> None:
        if self._dialog is not None:
            self._dialog.reject()
