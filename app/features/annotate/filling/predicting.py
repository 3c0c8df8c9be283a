"""Predictions that a person asks for over a selection: proposals, from the fit, from a run."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Literal, TypeAlias

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.detected_body import body_predictions
from stereotrack_core.annotation.propose import PROPOSED
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.pose_model.detect import detect_keypoints
from stereotrack_core.pose_model.detector import required_detector
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project import prefilling
from stereotrack_core.project.detectors import DetectorFill, plan_fill
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader, reference_pictures

from ....services.actions import Command
from ....session.changes import Part
from ....session.jobs import Job, NewestJob, Task
from ....session.runs import RunEntry
from ..clicking.detecting import NO_DETECTOR
from ..panels import AnnotationPanels, click_cameras

Source: TypeAlias = Literal["proposed", "fit", "run", "detector"]

_Detected: TypeAlias = tuple[Keypoints, Sequence[Prediction]]

_DETECTING = 0.5  # share of the time that detecting takes; fitting bodies takes the rest
NO_FIT = "The whole recording has not been fitted yet. Choose Fit whole recording first."


class PredictionWork:
    """Fills in the selection beside the window's thread, one source after the other."""

    def __init__(self, panels: AnnotationPanels) -> None:
        self._p, self._tasks = panels, panels.context.tasks
        self._keypoints = panels.context.session.keypoints
        self._job = NewestJob(self._tasks)
        panels.context.session.changes.watch(Part.PROJECT_CLOSING, self._job.cancel)

    @property
    def run(self) -> RunEntry | None:
        return self._p.context.session.finished_run

    @property
    def busy(self) -> bool:
        return self._job.busy

    def why_not(self, source: Source) -> str:
        if self.busy:
            return _BUSY
        now = self._p.reference.now
        no_fit = source == "fit" and (now is None or now.fit is None)
        return self.why_no_accept(source) or (NO_FIT if no_fit else "")

    def fill(self, source: Source) -> None:
        """Predict points of the selection: follow the image, or fill in from what is known."""
        project, recording, selection = self._p.project, self._p.recording, self._p.selection()
        if project is None or recording is None or self.why_not(source):
            return
        make = None if source == "proposed" else self._filling(source, project, recording)

        def work(task: Task) -> str:
            if make is None:
                return prefilling.propose_selection(project, recording, selection, task.work)
            return prefilling.fill_in(project, make(), selection, task.work)

        def tell(done: str) -> None:
            self._p.say(done)
            self._p.read_kept()

        title = "predicting from clicks" if make is None else "filling predictions"
        self._job.run(Job(title, work, tell))

    def why_no_detection(self) -> str:
        absent = "" if is_installed() else NO_DETECTOR
        return self._p.no_edit() or (_BUSY if self.busy else absent)

    def detect(self) -> None:
        project, recording, selection = self._p.project, self._p.recording, self._p.selection()
        if project is None or recording is None or self.why_no_detection():
            return
        frames, names = selection.frames, project.landmark_set().names
        cameras = {} if recording.guessed else click_cameras(recording)
        proportions = proportions_of(self._p.context.session.project.subject())

        def work(task: Task) -> _Detected:
            def say(done: int, words: str, share: float) -> None:
                if task.token.cancelled():
                    raise Cancelled
                task.report(share, f"{words} {done} of {len(frames)}")

            task.report(0.0, "finding the person")
            with FrameReader(reference_pictures(recording)) as reader:
                seen = detect_keypoints(
                    reader, required_detector(), frames,
                    on_frame=lambda done: say(done, "frame", _DETECTING * done / len(frames)),
                )  # fmt: skip
            found: list[Prediction] = []
            for done, frame in enumerate(frames):
                say(done, "body", _DETECTING + (1.0 - _DETECTING) * done / len(frames))
                found += body_predictions(seen.of_frame(frame), names, cameras, proportions)
            return seen, found

        take = partial(self._take, project, selection)
        self._job.run(Job("detecting keypoints", work, take))

    def _take(self, project: Project, selection: Selection, found: _Detected) -> None:
        if project is not self._p.project:
            return
        fills: list[DetectorFill] = []

        def make() -> tuple[DetectorState, DetectorState]:
            fills.append(plan_fill(project, *found, selection))
            return fills[0].before, fills[0].after

        def say() -> None:
            found = counted(fills[0].proposed, "landmark")
            self._p.say(f"{found} predicted from the detector in {selection.words()}.")

        self._keypoints.write(project, f"fill from detector in {selection.words()}", make, say)

    def _filling(
        self, source: Source, project: Project, recording: Recording
    ) -> Callable[[], prefilling.Filling]:
        """Function that makes the source of the predictions in the worker thread."""
        cameras, now, entry = click_cameras(recording), self._p.reference.now, self.run
        proportions = proportions_of(self._p.context.session.project.subject())
        name, held = ("", None) if entry is None else (entry.name, entry.now())

        def make() -> prefilling.Filling:
            if source == "fit" and now is not None and now.fit is not None:
                return prefilling.fit_filling(now.fit, cameras)
            if source == "detector":
                return prefilling.detector_filling(project, cameras, proportions)
            run = held.run() if source == "run" and held is not None else None
            if run is not None:
                return prefilling.run_filling(run, name, cameras, project)
            raise InputError(
                "no source for predictions",
                remedy="Choose a run that was tracked here or read from a file.",
            )

        return make

    def why_no_accept(self, source: Source) -> str:
        none = ""
        if source == "run" and self.run is None:
            none = "There is no finished run. Run the tracker first."
        elif source == "detector" and not self._keypoints.sources:
            none = "The project has no keypoints of a detector. Import predictions first."
        return self._p.no_edit() or none

    def accept(self, source: Source) -> None:
        """Let what a source has found in the selection be clicks: one edit."""
        run = prefilling.source_of_run(self.run.name) if self.run is not None else ""
        kept = {"proposed": (PROPOSED,), "fit": (prefilling.FIT,), "run": (run,)}
        sources = kept.get(source, tuple(self._keypoints.sources))
        called, recording = _SOURCES[source][3].replace("active ", ""), self._p.recording
        cameras = {} if recording is None else recording.cameras
        self._p.edit_selection(
            lambda project, chosen: prefilling.accept_predictions(
                project, sources, chosen, called, cameras
            )
        )


_BUSY = "Predictions are already being computed. Wait for them to finish."
_NOT_YET = (
    "Predictions do not become clicks until you accept them. They are no edit: undo leaves them."
)
_SOURCES: dict[Source, tuple[str, str, str, str, str]] = {
    "proposed": ("annotate-propose", "Predict from clicks", "Predict what is not clicked in the "
     "selected frames: from the clicks in them and around them, followed through the images of all "
     f"views. {_NOT_YET}", "predictions from clicks", "was predicted from clicks"),
    "fit": ("annotate-fill-fit", "Fill from the fit", "Predict landmarks in the selected frames "
     f"from the body fitted to the clicks. {_NOT_YET}",
     "points from the fit", "was filled from the fit"),
    "run": ("annotate-fill-run", "Fill from the active run", "Predict landmarks in the selected "
     f"frames from the tracker's active run. {_NOT_YET}",
     "points from the active run", "was filled from the tracker's active run"),
    "detector": ("annotate-fill-detector", "Fill from keypoints", "Predict landmarks in the "
     f"selected frames from the keypoints of the detectors. {_NOT_YET}",
     "points from keypoints", "was filled from detected or imported keypoints"),
}  # fmt: skip
"""By source: the command that predicts, its text and tip; what is accepted, and what that is."""


def prediction_commands(work: PredictionWork, menu: str) -> list[Command]:
    """Commands of predictions over the selection, in the order of their menu."""

    def named(words: str) -> str:
        name = "" if work.run is None else f"run “{work.run.name}”"
        return words.replace("the active run", name) if name else words

    fill = [
        Command(
            name, menu, text, tip, partial(work.fill, source), icon="prediction",
            why_not=partial(work.why_not, source), says=partial(named, text),
            section=source == "proposed",
        )
        for source, (name, text, tip, _what, _found) in _SOURCES.items()
    ]  # fmt: skip
    accept = [
        Command(
            "annotate-accept" + ("" if source == "proposed" else f"-{source}"), menu,
            f"Accept {what}", f"Turn what {found} in the selection into clicks, as one edit. "
            "Existing clicks do not change. What is less certain than the limit stays open.",
            partial(work.accept, source),
            "Ctrl+Shift+A" if source == "proposed" else "", icon="accept",
            why_not=partial(work.why_no_accept, source), says=partial(named, f"Accept {what}"),
            section=source == "proposed",
        )
        for source, (_name, _text, _tip, what, found) in _SOURCES.items()
    ]  # fmt: skip
    detect = Command(
        "annotate-detect", menu, "Fill from detector", "Let the installed pose detector look at "
        "the selected frames in all views, and predict landmarks from what it sees. No click is "
        "needed before. Predictions do not become clicks until you accept them.", work.detect,
        icon="prediction", why_not=work.why_no_detection,
    )  # fmt: skip
    return [*fill, detect, *accept]
