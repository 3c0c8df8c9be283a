"""What is known about the clicks of the frame that is shown: hints, fit, kept predictions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from stereotrack_core.annotation import frame_clicks
from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.predict import volume_in_sight
from stereotrack_core.annotation.propose import ACCEPTED_SIGMA
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.points import Volume
from stereotrack_core.project.history import Changed
from stereotrack_core.project.prefilling import accepted_sigma
from stereotrack_core.worker_processes import TaskProcess

from ....context import Context
from ....session.changes import Part
from ....session.jobs import NewestAnswer
from .annotating import Annotating
from .marks import FEWEST, FrameMarks, body_off_mm
from .proposing import ProposalPresenter

_SOON_MS = 30
_REST_MS = 60
_PAUSE_MS = 250


class AnnotationFacts:
    """Asks for hints and the fit whenever clicks change; gathers what marks are made of.

    `cameras`: names of the cameras in whose images clicks are looked for, one for each view.
    """

    def __init__(
        self,
        context: Context,
        annotating: Annotating,
        cameras: Callable[[], Sequence[str]],
        proposals: ProposalPresenter,
    ) -> None:
        session = context.session
        document, project, clouds = session.document, session.project, session.clouds
        self._document, self._project, self._clouds = document, project, clouds
        self._compared, self.proposals = session.cameras, proposals
        self._annotating, self._cameras = annotating, cameras
        self._active = False
        self._measured: Mapping[str, float] | None = None
        self.use_depth = True
        """Whether the body is fitted to measured points too."""
        told = partial(session.changes.tell, Part.HINTS)
        self._hints: NewestAnswer[frame_clicks.ClickHints] = NewestAnswer(
            context.tasks, self._hint_question, frame_clicks.hints_of, "click hints", told
        )
        self._fitters = (_FitProcess(), _FitProcess())
        self._fit: NewestAnswer[frame_clicks.ShownFit] = NewestAnswer(
            context.tasks, lambda: self._question(None), self._fitters[0].fit, "live fit", told
        )
        self._deep: NewestAnswer[frame_clicks.ShownFit] = NewestAnswer(
            context.tasks, self._deep_question, self._fitters[1].fit, "fit with depth", told
        )
        # curves and predictions come after the click or the picture is painted
        self._soon = session.later(self._hints.ask, _SOON_MS)
        # frames that are only passed by are not fitted
        self._rest = session.later(self._fit.ask, _REST_MS)
        # measured points take longer, so they wait until somebody looks at what was clicked
        self._pause = session.later(self._deep.ask, _PAUSE_MS)
        self._timers = (self._soon, self._rest, self._pause)
        self._sources = (self._hints, self._fit, self._deep)
        watch = session.changes.watch
        watch(Part.CLICKS, self.ask)
        watch(Part.CHOICE, self._soon.start)
        watch(Part.CLOUD, self._on_measured)
        session.changes.hear(Part.EDIT, self._on_changed)
        watch(Part.PROJECT_OPENED | Part.RECORDING_CLOSED, self._forget)

    def set_active(self, active: bool) -> None:
        self._active = active
        self.proposals.set_active(active)
        self.ask()

    def ask(self) -> None:
        for timer in self._timers:
            timer.start()

    def hints(self) -> frame_clicks.ClickHints | None:
        return self._hints.at(self._document.frame)

    def predicted(self) -> FrameMarks:
        """Clicks and predictions alone: commands ask for them whenever something has changed."""
        frame, annotating = self._document.frame, self._annotating
        return FrameMarks(
            frame=frame,
            clicks=tuple(annotating.clicks().values()),
            landmark_set=annotating.landmark_set,
            predictions=(*self._kept(frame), *self.proposals.now()),
            hints=self.hints(),
        )

    def now(self) -> FrameMarks:
        annotating, project = self._annotating, self._project.project
        at_hand = annotating.at_hand() if self._active else None
        recording, predicted, fit = self._document.recording, self.predicted(), self._best_fit()
        return replace(
            predicted,
            chosen=annotating.choice.landmark if self._active else "",
            at_hand=at_hand.key if at_hand is not None else None,
            held=annotating.held(),
            asked=frozenset(one.key for one in self.proposals.doubtful()),
            accuracy=self.proposals.words(body_off_mm(predicted.hints, fit)),
            detecting=self.proposals.detections.words(),
            fit=fit,
            views=self.view_names(),
            offers={name: annotating.next_in(name) for name in annotating.shown_cameras()}
            if self._active
            else {},
            unused=annotating.unused(),
            doubtful=self._compared.now,
            calibrated=recording is None or not recording.guessed,
            accepted_sigma=ACCEPTED_SIGMA if project is None else accepted_sigma(project),
        )

    def view_names(self) -> Mapping[str, str]:
        recording = self._document.recording
        return recording.camera_names() if recording is not None else {}

    def settled(self) -> bool:
        waiting = any(timer.isActive() for timer in self._timers) or self._waits_for_depth()
        known = self.proposals.settled() and all(source.settled() for source in self._sources)
        return known and not waiting

    def close(self) -> None:
        for timer in self._timers:
            timer.stop()
        self.proposals.close()
        self.proposals.detections.close()
        for fitter in self._fitters:
            fitter.close()
        for source in self._sources:
            source.close()

    def _on_changed(self, changed: Changed) -> None:
        if "repeat_click" in changed.tables:
            self._measured = None
        if changed.tables & {"choice", "subject", "camera_use"}:
            self.ask()

    def _forget(self) -> None:
        """Forget what is known of another project, and whatever still comes."""
        self._measured = None
        for source in self._sources:
            source.close()
        self.ask()

    def _hint_question(self) -> frame_clicks.HintQuestion | None:
        recording = self._document.recording
        clicks = self._annotating.used_clicks()
        if recording is None or recording.guessed or not self._active or not clicks:
            return None
        looking = [recording.reference_camera(view) for view in recording.views]
        return frame_clicks.HintQuestion(
            **self._known(),
            cameras=recording.cameras,
            landmark=self._annotating.choice.landmark,
            shown=tuple(self._cameras()),
            volume=volume_in_sight(Volume.of(self._clouds.parameters), looking),
        )

    def _known(self) -> dict[str, Any]:
        project, annotating = self._project.project, self._annotating
        if self._measured is None:  # how good clicks are, by annotating again
            self._measured = project.click_sigmas() if project is not None else {}
        return {
            "frame": self._document.frame,
            "clicks": annotating.used_clicks(),
            "landmark_set": annotating.landmark_set,
            "proportions": proportions_of(self._project.subject()),
            "sigmas": self._measured,
        }

    def _best_fit(self) -> frame_clicks.ShownFit | None:
        """The fit with measured points if it is of the present clicks, else the quick one."""
        frame = self._document.frame
        deep, clicks = self._deep.at(frame), self._annotating.used_clicks()
        if deep is not None and self.use_depth and deep.question.clicks == clicks:
            return deep
        return self._fit.at(frame)

    def _deep_question(self) -> frame_clicks.FitQuestion | None:
        if not self._wants_depth():
            return None
        frame = self._document.frame
        cloud = self._clouds.cloud(frame)
        if cloud is None:
            self._clouds.ask(frame)
        return self._question(cloud) if cloud is not None else None

    def _question(self, cloud: Cloud | None) -> frame_clicks.FitQuestion | None:
        recording = self._document.recording
        if recording is None or recording.guessed or not self._worth_fitting():
            return None
        names = {view.image.camera for view in recording.views}
        names |= {click.camera for click in self._annotating.used_clicks()}
        return frame_clicks.FitQuestion(
            **self._known(),
            cameras={name: one for name, one in recording.cameras.items() if name in names},
            views=self.view_names(),
            fps=recording.fps,
            cloud=cloud,
        )

    def _worth_fitting(self) -> bool:
        positions = [click for click in self._annotating.used_clicks() if click.position]
        return self._active and not self._document.playing and len(positions) >= FEWEST

    def _wants_depth(self) -> bool:
        return self.use_depth and self._clouds.available and self._worth_fitting()

    def _waits_for_depth(self) -> bool:
        frame, clouds = self._document.frame, self._clouds
        return self._wants_depth() and clouds.cloud(frame) is None and not clouds.given_up(frame)

    def _on_measured(self) -> None:
        if self._worth_fitting() and self.use_depth:
            self._deep.ask()

    def _kept(self, frame: int) -> tuple[Prediction, ...]:
        project, recording = self._project.project, self._document.recording
        if project is None or recording is None or self._annotating.blind():
            return ()
        detected = self.proposals.detections.at(frame) if self._active else ()
        return (*project.predictions.at(frame), *detected)


class _FitProcess(TaskProcess):
    """Fits the body to the clicks of one frame in another process."""

    def fit(self, question: frame_clicks.FitQuestion) -> frame_clicks.ShownFit:
        cloud = question.cloud
        if cloud is not None:  # the fit takes points alone
            cloud = replace(cloud, depths={})
        shown: frame_clicks.ShownFit = self(
            partial(frame_clicks.fitted_body, replace(question, cloud=cloud))
        )
        return replace(shown, question=question)
