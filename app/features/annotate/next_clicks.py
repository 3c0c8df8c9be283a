"""Where a click helps most, ranked beside the window's thread, and followed edit by edit."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from stereotrack_core.annotation import next_clicks as ranking_rules
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.doubts import Doubt, unlike_the_others
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


class _Ranker:
    """Ranks the places of one project in one thread; another project gets another ranker."""

    def __init__(self, project: Project, cameras: Mapping[str, Camera]) -> None:
        self._project, self._cameras = project, cameras
        self._ranking: ranking_rules.NextClicks | None = None

    def rank(
        self,
        fit: TrajectoryFit,
        run: LandmarkTrajectory | None,
        wanted_deg: float,
        edited: frozenset[int] | None,
        doubts: Mapping[ClickKey, Doubt],
    ) -> Ranking:
        """Rank anew, or take in the clicks of `edited` frames; `doubts` are what images tell."""
        project, gaps = self._project, gaps_of(self._project)
        ranking, self._ranking = self._ranking, None  # where this fails, the next one begins anew
        if ranking is None or edited is None:
            unused = project.marks.unused_cameras()
            cameras = {name: one for name, one in self._cameras.items() if name not in unused}
            ranking = ranking_rules.NextClicks(
                cameras, project.landmark_set(), fit,
                project.clicks.all(with_deleted=True),
                sigma=project.click_sigmas(), run=run,
            )  # fmt: skip
            ranking.add(doubts)
        else:
            for frame in sorted(edited):
                clicks = (*project.clicks.at(frame), *project.clicks.deleted_at(frame))
                ranking.update(frame, clicks)
        self._ranking = ranking
        counts = np.ones(len(fit.frame), dtype=np.bool_)
        for gap in gaps:
            counts &= (fit.frame < gap.start) | (fit.frame >= gap.stop)
        sigma = ranking.gains.limb_sigma_deg()[counts]
        clicked = int(ranking.gains.clicked()[counts].any(axis=1).sum())
        best = ranking.best(ranking_rules.Wish(count=_MOST, gaps=gaps))
        return Ranking(best, ranking_rules.good_enough(sigma, wanted_deg, clicked))


class NextPresenter:
    """Ranks the places of one project; a fit of the whole recording has to be there.

    `ranked` is called with the ranking; None: nothing is fitted, so that nothing can be ranked.
    """

    def __init__(self, tasks: TaskList, ranked: Callable[[Ranking | None], None]) -> None:
        self._tasks, self._tell = tasks, ranked
        self._project: Project | None = None
        self._fit: TrajectoryFit | None = None
        self._run: LandmarkTrajectory | None = None
        self.wanted_deg = WANTED_DEG
        self._ranker: _Ranker | None = None
        self._worker = LatestOnly(
            tasks, lambda rank: rank(), "rank clicks", self._on_ranked,
            self._on_failed, late=True,
        )  # fmt: skip
        self._build, self._edited = False, frozenset[int]()
        self._doubts: Mapping[ClickKey, Doubt] = {}
        self._checking = NewestJob(tasks)

    @property
    def idle(self) -> bool:
        return self._worker.settled()

    def set_project(self, project: Project | None, cameras: Mapping[str, Camera]) -> None:
        self._worker.close()
        self._ranker = None if project is None else _Ranker(project, cameras)
        self._project = project
        self._fit = self._run = None
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
        if self._fit is None or self._ranker is None:
            return
        # what no answer has taken in yet; a frame that is taken in twice does no harm
        self._build, self._edited = self._build or build, self._edited | frames
        edited = None if self._build else self._edited
        known = self._fit, self._run, self.wanted_deg, edited, self._doubts
        self._worker.ask(partial(self._ranker.rank, *known))

    def _end(self) -> None:
        if self._worker.settled():
            self._build, self._edited = False, frozenset()

    def _on_ranked(self, _asked: object, ranking: Ranking) -> None:
        self._end()
        if self._fit is not None:
            self._tell(ranking)

    def _on_failed(self, _asked: object, error: Exception) -> None:
        self._end()
        self._tasks.failed(error)
