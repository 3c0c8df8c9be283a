"""Where a click helps most, ranked beside the window's thread, and followed edit by edit."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation import next_clicks as ranking_rules
from stereotrack_core.annotation.appearance import unlike_the_others
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.doubts import Doubt
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.counting import counted
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import gaps_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...session.jobs import Job, LatestOnly, NewestJob, TaskList

WANTED_DEG = 3.0  # angle by which limbs may be off where nobody has said otherwise
_WANTED = "wanted_deg"
_MOST = 500
_MANY_FRAMES = 50


@dataclass(frozen=True)
class Ranking:
    """What to click next."""

    suggestions: tuple[ranking_rules.Suggestion, ...]
    sign: ranking_rules.StopSign  # whether the wanted accuracy is reached


@dataclass(frozen=True, eq=False)
class _Order:
    """Inputs of one ranking: all clicks if `build`, else those of the `edited` frames."""

    fit: TrajectoryFit
    run: LandmarkTrajectory | None
    wanted_deg: float
    build: bool
    edited: frozenset[int]
    doubts: Mapping[ClickKey, Doubt]  # that the images tell


class _Ranker:
    """Ranks the places of one project in one thread; another project gets another ranker."""

    def __init__(self, project: Project, cameras: Mapping[str, Camera]) -> None:
        self._project, self._cameras = project, cameras
        self._ranking: ranking_rules.NextClicks | None = None

    def __call__(self, order: _Order) -> Ranking:
        project, gaps = self._project, gaps_of(self._project)
        ranking, self._ranking = self._ranking, None  # where this fails, the next one begins anew
        if ranking is None or order.build:
            unused = project.marks.unused_cameras()
            cameras = {name: one for name, one in self._cameras.items() if name not in unused}
            ranking = ranking_rules.NextClicks(
                cameras, project.landmark_set(), order.fit,
                project.clicks.all(with_deleted=True),
                sigma=project.click_sigmas(), run=order.run,
            )  # fmt: skip
            ranking.add(order.doubts)
        else:
            for frame in sorted(order.edited):
                clicks = (*project.clicks.at(frame), *project.clicks.deleted_at(frame))
                ranking.update(frame, clicks)
        self._ranking = ranking
        counts = np.ones(len(order.fit.frame), dtype=np.bool_)
        for gap in gaps:
            counts &= (order.fit.frame < gap.start) | (order.fit.frame >= gap.stop)
        sigma = ranking.gains.limb_sigma_deg()[counts]
        clicked = int(ranking.gains.clicked()[counts].any(axis=1).sum())
        best = ranking.best(ranking_rules.Wish(count=_MOST, gaps=gaps))
        return Ranking(best, ranking_rules.good_enough(sigma, order.wanted_deg, clicked))


class NextPresenter:
    """Ranks the places of one project; a fit of the whole recording has to be there.

    `ranked` is called with the ranking; None: nothing is fitted, so that nothing can be ranked.
    """

    def __init__(self, tasks: TaskList, ranked: Callable[[Ranking | None], None]) -> None:
        self._tasks, self._tell = tasks, ranked
        self._project: Project | None = None
        self._cameras: Mapping[str, Camera] = {}
        self._fit: TrajectoryFit | None = None
        self._run: LandmarkTrajectory | None = None
        self.wanted_deg = WANTED_DEG
        self._worker: LatestOnly | None = None
        self._build, self._edited = False, frozenset[int]()
        self._newest: _Order | None = None
        self._doubts: Mapping[ClickKey, Doubt] = {}
        self._checking = NewestJob(tasks)

    @property
    def idle(self) -> bool:
        return self._worker is None or self._newest is None

    def set_project(self, project: Project | None, cameras: Mapping[str, Camera]) -> None:
        if self._worker is not None:
            self._worker.close()
            self._worker = None
        self._project, self._cameras = project, cameras
        self._fit = self._run = self._newest = None
        self._doubts = {}
        self._checking.give_up()
        if project is not None:
            self.wanted_deg = float(project.view_settings.get(_WANTED, WANTED_DEG))
        self._tell(None)

    def set_fit(self, fit: TrajectoryFit | None) -> None:
        self._fit = fit
        if fit is None:
            self._tell(None)
        else:
            self._ask(build=True)

    def set_run(self, run: LandmarkTrajectory | None) -> None:
        if run is not self._run:
            self._run = run
            self._ask(build=True)

    def set_wanted(self, degrees: float) -> None:
        self.wanted_deg = degrees
        if self._project is not None and not self._project.read_only:
            self._project.view_settings.set(_WANTED, degrees)
        self._ask()

    def follow(self, changed: Changed) -> None:
        frames = changed.frames("click")
        anew = bool(changed.tables & {"frame_flag", "camera_use"})
        self._doubts = {key: one for key, one in self._doubts.items() if key.frame not in frames}
        if frames or anew:
            self._ask(build=anew or len(frames) > _MANY_FRAMES, frames=frames)

    def why_not_check(self) -> str:
        if self._fit is None:
            return "Fit the whole recording first; its doubts are listed with those of the images."
        return "The clicks are being checked." if self._checking.busy else ""

    def check(self, recording: Recording, say: Callable[[str], object]) -> None:
        """Look for clicks that images contradict; they join the suggestions."""
        project = self._project
        if project is None or self.why_not_check():
            return

        def take(found: Mapping[ClickKey, Doubt]) -> None:
            self._doubts = found
            self._ask(build=True)
            words = f"{counted(len(found), 'click')} may be wrong by the images"
            say(f"{words}; see Suggested clicks." if found else "The images contradict no click.")

        clicks = project.clicks.used()
        work = lambda task: unlike_the_others(recording, clicks, task.work)  # noqa: E731
        self._checking.run(Job("checking clicks in the images", work, take))

    def _ask(self, *, build: bool = False, frames: frozenset[int] = frozenset()) -> None:
        if self._fit is None or self._project is None:
            return
        if self._worker is None:
            ranker = _Ranker(self._project, self._cameras)
            how = ranker, "rank clicks", self._on_ranked, self._on_failed
            self._worker = LatestOnly(self._tasks, *how, late=True)
        # what no answer has taken in yet; a frame that is taken in twice does no harm
        self._build, self._edited = self._build or build, self._edited | frames
        order = _Order(self._fit, self._run, self.wanted_deg, self._build, self._edited,
                       self._doubts)  # fmt: skip
        self._newest = order
        self._worker.ask(order)

    def _end(self, order: _Order) -> None:
        if order is self._newest:
            self._newest, self._build, self._edited = None, False, frozenset()

    def _on_ranked(self, order: _Order, ranking: Ranking) -> None:
        self._end(order)
        if self._fit is not None:
            self._tell(ranking)

    def _on_failed(self, order: _Order, error: Exception) -> None:
        self._end(order)
        self._tasks.failed(error)
