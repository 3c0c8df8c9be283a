"""Where a click helps most, ranked beside the window's thread, and followed edit by edit."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.annotation.fit.measurement import USUAL_SIGMA
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.next_clicks import NextClicks, Wish
from stereotrack_core.annotation.stop_sign import good_enough
from stereotrack_core.annotation.suggestion import StopSign, Suggestion
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.click_sigma import measured_sigmas
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ..tasks.newest import NewestWins
from .selection import gaps_of

WANTED_DEG = 3.0
"""Angle by which limbs may be off where nobody has said otherwise."""

_WANTED = "wanted_deg"
_MOST = 200
_MANY_FRAMES = 50


@dataclass(frozen=True)
class Ranking:
    """What to click next.

    Attributes
    ----------
    suggestions : tuple of Suggestion
        Best first.
    sign : StopSign
        Whether the wanted accuracy is reached.
    """

    suggestions: tuple[Suggestion, ...]
    sign: StopSign


@dataclass
class _Inbox:
    """What the worker has not taken in yet."""

    build: bool = False
    frames: set[int] = field(default_factory=set)


class NextPresenter(QObject):
    """Ranks the places of one project; a fit of the whole recording has to be there.

    Signals
    -------
    ranked : Ranking or None
        None: nothing is fitted, so that nothing can be ranked.
    failed : Exception
    """

    ranked = Signal(object)
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._project: Project | None = None
        self._cameras: Mapping[str, Camera] = {}
        self._fit: TrajectoryFit | None = None
        self._run: LandmarkTrajectory | None = None
        self._wish = Wish(count=_MOST)
        self._wanted = WANTED_DEG
        self._worker: NewestWins | None = None
        self._ranking: NextClicks | None = None
        self._inbox, self._lock = _Inbox(), threading.Lock()
        self._asked = self._told = 0

    @property
    def wanted_deg(self) -> float:
        """Angle by which limbs may be off."""
        return self._wanted

    @property
    def idle(self) -> bool:
        """Whether the ranking is up to date."""
        return self._worker is None or self._told == self._asked

    def set_project(self, project: Project | None, cameras: Mapping[str, Camera]) -> None:
        """Rank another project's places, or none; `cameras` are those people click in."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None
        self._project, self._cameras = project, cameras
        self._fit = self._run = self._ranking = None
        self._wish = Wish(count=_MOST)
        self._inbox = _Inbox()
        if project is not None:
            self._wanted = float(project.view_settings.get(_WANTED, WANTED_DEG))
        self.ranked.emit(None)

    def set_fit(self, fit: TrajectoryFit | None) -> None:
        """Rank by another fit of the recording."""
        self._fit = fit
        if fit is None:
            self.ranked.emit(None)
        else:
            self._ask(build=True)

    def set_run(self, run: LandmarkTrajectory | None) -> None:
        """Look also at where a tracker disagrees."""
        if run is not self._run:
            self._run = run
            self._ask(build=True)

    def set_frames(self, frames: range | None) -> None:
        """Look only at these frames; None: at all of them."""
        self._wish = Wish(count=_MOST, frames=frames)
        self._ask()

    def set_wanted(self, degrees: float) -> None:
        """Be content when limbs are off by no more than this."""
        self._wanted = degrees
        if self._project is not None and not self._project.read_only:
            self._project.view_settings.set(_WANTED, degrees)
        self._ask()

    def follow(self, changed: Changed) -> None:
        """Take in an edit."""
        frames = changed.frames("click")
        gaps = "frame_flag" in changed.tables
        if frames or gaps:
            self._ask(build=gaps or len(frames) > _MANY_FRAMES, frames=frames)

    def close(self) -> None:
        """End the worker."""
        self.set_project(None, {})

    def _ask(self, *, build: bool = False, frames: frozenset[int] = frozenset()) -> None:
        if self._fit is None or self._project is None:
            return
        with self._lock:
            self._inbox.build |= build
            self._inbox.frames |= frames
        if self._worker is None:
            self._worker = NewestWins(self._rank, "rank clicks")
            self._worker.answered.connect(self._on_ranked)
            self._worker.failed.connect(self._on_failed)
        self._asked += 1
        self._worker.ask(self._asked)

    def _rank(self, _question: int) -> Ranking:
        """Called in the worker's thread, which alone touches the ranking."""
        project, fit = self._project, self._fit
        assert project is not None  # noqa: S101 - asked before
        assert fit is not None  # noqa: S101 - asked before
        with self._lock:
            inbox, self._inbox = self._inbox, _Inbox()
        gaps = gaps_of(project)
        if inbox.build or self._ranking is None:
            self._ranking = NextClicks(
                self._cameras, project.landmark_set(), fit, project.clicks.all(with_deleted=True),
                sigma=measured_sigmas(project, USUAL_SIGMA), run=self._run, gaps=gaps,
            )  # fmt: skip
        else:
            for frame in sorted(inbox.frames):
                there = (*project.clicks.at(frame), *project.clicks.deleted_at(frame))
                self._ranking.update(frame, there)
        counts = np.ones(len(fit.frame), dtype=np.bool_)
        for gap in gaps:
            counts &= (fit.frame < gap.start) | (fit.frame >= gap.stop)
        sigma = self._ranking.gains.limb_sigma_deg()[counts]
        return Ranking(self._ranking.best(self._wish), good_enough(sigma, self._wanted))

    @Slot(object, object)
    def _on_ranked(self, question: int, ranking: Ranking) -> None:
        self._told = question
        if self._fit is not None:
            self.ranked.emit(ranking)

    @Slot(object, object)
    def _on_failed(self, question: int, error: Exception) -> None:
        self._told = question
        self.failed.emit(error)
