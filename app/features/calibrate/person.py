"""Calibrate from the person: asks for a length, calculates beside the window, and says how well."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFormLayout

from stereotrack_core.annotation.click import UNCERTAIN, Visibility
from stereotrack_core.calibrate.person import KnownLength, PersonCalibration, calibrate_from_person
from stereotrack_core.errors import InputError
from stereotrack_core.work import Work

from ...context import Context
from ...session.changes import PROJECT, RECORDING
from ...session.jobs import Job, NewestJob
from ...session.replacing import replace_cameras
from ...session.session import Session, unless
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

    def __init__(self, context: Context, names: tuple[str, ...]) -> None:
        parent = context.docks.dialog_parent
        super().__init__("Calibrate from the person", "Calibrate", self._on_button, parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._context, self._job = context, NewestJob(context.tasks)
        context.session.changes.watch(PROJECT | RECORDING, self.reject)
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
        if (found := self._found) is not None:
            session, what = self._context.session, f"The cameras are calibrated. {found.words()}"
            if self.attempt(lambda: replace_cameras(session, found.cameras, what)):
                self.accept()
            return
        ends = [str(box.currentData()) for box in self.ends]
        length = KnownLength(ends[0], ends[1], self.length.stored() / 1000.0)
        if not length.metres or ends[0] == ends[1]:
            self.say("Choose two landmarks, and type the length between them.", error=True)
            return
        self.say("Calculating …")
        self.accept_button.setEnabled(False)
        work = self._work(length, self.focal.stored())
        title = "calibrating from the person"
        self._job.run(Job(title, lambda task: work(task.work), self._on_found, self._on_failed))

    def _work(self, length: KnownLength, focal: float) -> Callable[[Work], PersonCalibration]:
        """The calculation; a focal length of 0 pixels is found."""
        session = self._context.session
        recording, project = session.document.recording, session.project.project
        assert recording is not None and project is not None  # noqa: S101, PT018 - it was asked
        cameras = [recording.reference_camera(view) for view in recording.views]
        sizes = {one.name: (one.width, one.height) for one in cameras}
        share = focal / max(max(size) for size in sizes.values()) or None
        clicks: dict[tuple[int, str], dict[str, tuple[float, float]]] = {}
        for one in project.clicks.all():
            sure = one.visibility == Visibility.SEEN and one.flag != UNCERTAIN
            if sure and one.position is not None:
                clicks.setdefault((one.frame, one.landmark), {})[one.camera] = one.position
        return partial(calibrate_from_person, clicks, sizes, length, share)

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
            self._context.notifier.error(error)


_ENDS = ("First", "Second")


def why_not(session: Session) -> str:
    """Why the cameras of the recording cannot be calculated from its project's clicks."""
    recording = session.document.recording
    if recording is None or session.no_project():
        return session.no_project()
    known = "The cameras of the recording are known. Attach a calibration to replace them."
    alone = all(view.kind == "mono" for view in recording.views) and len(recording.views) > 1
    two = "This needs two ordinary cameras or more, and no stereo cameras."
    return unless(recording.guessed, known) or unless(alone, two)


def ask(context: Context) -> None:
    """Ask for a length, unless nothing can be calculated."""
    project = context.session.project.project
    if project is not None and not why_not(context.session):
        PersonDialog(context, project.landmark_set().names).open()
