"""Proposals for the frame that is shown and, one step ahead, for the one that follows it."""

import threading
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

from stereotrack_core.annotation.click import Click, ClickKey, Prediction
from stereotrack_core.annotation.detected_body import told_once
from stereotrack_core.annotation.follow import MOST_FRAMES, follow_clicks
from stereotrack_core.annotation.follow_body import BodyStep, FollowedBody, follow_body, told_by
from stereotrack_core.annotation.landmark_filter import WANTED_MM, ProposalQuestion
from stereotrack_core.annotation.propose import Proposals, Proposer
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.history import Changed
from stereotrack_core.project.prefilling import accepted_sigma, clicks_around
from stereotrack_core.project.selection import gaps_of
from stereotrack_core.recording.reader import FrameReader

from ....context import Context
from ....session.changes import PROJECT, RECORDING, Part
from ....session.document import Shared
from ....session.jobs import LatestOnly, NewestAnswer
from .annotating import Annotating
from .detecting import FrameDetections

_SOON_MS = 20
_WANTED = "wanted_mm"
_CHAIN = 4  # clicked frames before and after from which the body is followed, one to the next


@dataclass(frozen=True, eq=False)
class _Way:
    """Clicks that are to be followed to a frame, or the body that is followed from `start`."""

    reader: Shared[FrameReader]
    clicks: tuple[Click, ...]
    frame: int
    follow: Callable[..., tuple[Prediction, ...] | BodyStep | None]
    start: int | None = None
    overtaken: threading.Event = field(default_factory=threading.Event)


def _follow(way: _Way) -> tuple[Prediction, ...] | BodyStep | None:
    """Places of the clicks or motion of the body; None if it was stopped or lost."""
    stopped = way.overtaken.is_set
    with way.reader.used() as reader:
        found = way.follow(reader, way.clicks, cancelled=stopped)
    return None if stopped() else found


class ProposalPresenter:
    """Proposes beside the window's thread whenever clicks or the frame change."""

    def __init__(
        self, context: Context, annotating: Annotating, detections: FrameDetections
    ) -> None:
        session, self._annotating, self.detections = context.session, annotating, detections
        self._document, self._project = session.document, session.project
        self._tell = partial(session.changes.tell, Part.PROPOSALS)
        self._active = self._was_wanted = False
        self._cameras: Mapping[str, Camera] = {}
        self._around: tuple[int, tuple[Click, ...]] | None = None
        self._followed: dict[tuple[ClickKey, object, int], Prediction | None] = {}
        self._steps: dict[tuple[int, int], tuple[object, BodyStep | None]] = {}
        self._way: _Way | None = None
        self._tell_failure = context.notifier.error
        self.answer: NewestAnswer[Proposals] = NewestAnswer(
            context.tasks, self._question, Proposer(), "proposals", self._tell
        )
        self._following = LatestOnly(
            context.tasks, _follow, "follow clicks", self._on_followed, self._on_not_followed
        )
        # the click or the picture is painted first
        self._soon = session.later(self._ask, _SOON_MS)
        session.changes.watch(Part.CLICKS | Part.PLAYING | Part.KEYPOINTS, self._soon.start)
        session.changes.hear(Part.EDIT, self._on_changed)
        session.changes.watch(PROJECT | RECORDING, self._forget)

    # ---- what is known

    def _known_now(self) -> Proposals | None:
        return self.answer.at(self._document.frame) if self._wanted() else None

    def now(self) -> tuple[Prediction, ...]:
        known, clicks = self._known_now(), self._annotating.clicks()
        found = known.predictions if known is not None else ()
        return tuple(one for one in found if one.key not in clicks)

    def doubtful(self) -> tuple[Prediction, ...]:
        """Proposals of this frame to be looked at one by one, the most telling first."""
        known, project, recording = (
            self._known_now(),
            self._project.project,
            self._document.recording,
        )
        if known is None or project is None or recording is None:
            return ()
        clicks = self._annotating.clicks()
        found = known.doubtful(recording.cameras, accepted_sigma(project))
        return tuple(one for one in found if one.key not in clicks)

    def words(self, body_mm: float) -> str:
        """Accuracy of the frame, and the number of clicks up to the wanted one, as a sentence."""
        known = self._known_now()
        return known.words(body_mm) if known is not None else ""

    def ahead(self) -> dict[int, frozenset[str]]:
        """Landmarks that are proposed, by frame: in the one that is shown and the one after it."""
        found = {self._document.frame: frozenset(one.landmark for one in self.now())}
        after = self._annotating.following_frame()
        if after is not None and self._wanted():
            clicked = self._clicked_in(after)
            names = {one.landmark for one in self._found(after) if one.key not in clicked}
            told = told_by(self._steps_to(after), after)
            found[after] = frozenset(names) | (told if not clicked else frozenset())
        return {frame: names for frame, names in found.items() if names}

    def settled(self) -> bool:
        sources = (self.answer, self._following, self.detections)
        return not self._soon.isActive() and all(source.settled() for source in sources)

    # ---- what changes it

    def set_active(self, active: bool) -> None:
        self._active = active
        self.detections.set_active(active)
        self._soon.start()

    def wanted_mm(self) -> float:
        """Accuracy of a frame's landmarks up to which clicks are asked for, by project."""
        project = self._project.project
        stored = WANTED_MM if project is None else project.view_settings.get(_WANTED, WANTED_MM)
        return float(stored)

    def set_wanted(self, millimetres: float) -> None:
        if self._project.project is not None:
            self._project.project.view_settings.set(_WANTED, millimetres)
        self._soon.start()

    def close(self) -> None:
        self._soon.stop()
        self._overtake()
        self.answer.close()
        self._following.close()

    def _forget(self) -> None:
        self.close()
        self._around, self._followed, self._steps = None, {}, {}
        self._soon.start()

    def _on_changed(self, changed: Changed) -> None:
        if changed.tables & {"choice", "landmark_set", "frame_flag", "camera_use"}:
            self._around = None
            self._soon.start()
        if changed.frames("click") - {self._document.frame}:
            self._around = None
            self._soon.start()

    # ---- asking

    def _wanted(self) -> bool:
        document = self._document
        there = self._project.project is not None and document.recording is not None
        return there and self._active and not document.playing and not self._annotating.blind()

    def _ask(self) -> None:
        self._overtake()
        self.answer.ask()
        self._follow_next()
        before, self._was_wanted = self._was_wanted, self._wanted()
        if before or self._was_wanted:
            self._tell()

    def _overtake(self) -> None:
        if self._way is not None:
            self._way.overtaken.set()
            self._way = None

    def _follow_next(self) -> None:
        reader = self._document.reader
        if not self._wanted() or reader is None:
            return
        for frame in (self._document.frame, self._annotating.following_frame()):
            if frame is None:
                continue
            self._way = self._body_way(reader, frame)
            if self._way is None and (clicks := self._to_follow(frame)):
                self._way = _Way(reader, clicks, frame, partial(follow_clicks, frames=(frame,)))
            if self._way is not None:
                self._following.ask(self._way)
                return

    def _body_way(self, reader: Shared[FrameReader], frame: int) -> _Way | None:
        """Work for the next pair of frames between which the body was not followed yet."""
        recording, project = self._document.recording, self._project.project
        if recording is None or recording.guessed or project is None:
            return None
        clicks = self._known(frame)
        for start, end in self._pairs(frame, clicks):
            if self._steps.get((start, end), (None, None))[0] == _told(clicks, start):
                continue
            proportions = proportions_of(self._project.subject())
            names = {one.camera for one in clicks} & set(recording.cameras)
            cameras = {name: recording.cameras[name] for name in recording.cameras if name in names}
            body = FollowedBody(cameras, proportions, self._annotating.landmark_set)
            follow = partial(follow_body, start=start, frame=end, body=body)
            return _Way(reader, clicks, end, follow, start)
        return None

    def _known(self, frame: int) -> tuple[Click, ...]:
        """Clicks around a frame, those of the frame that is shown included."""
        own = self._annotating.clicks().values()
        return tuple(one for one in (*self._clicks_around(), *own) if one.frame != frame)

    @staticmethod
    def _pairs(frame: int, clicks: Sequence[Click]) -> tuple[tuple[int, int], ...]:
        """Clicked frames on both sides, each with the next one on the way to a frame."""
        frames = sorted({one.frame for one in clicks})
        before = [*(one for one in frames if one < frame)][-_CHAIN:]
        after = [*(one for one in frames if one > frame)][:_CHAIN]
        to_it = ((*before, frame), (*reversed(after), frame))
        pairs = [tuple(pairwise(way)) for way in to_it]
        return (*reversed(pairs[0]), *reversed(pairs[1]))

    def _steps_to(self, frame: int) -> tuple[BodyStep, ...]:
        """Motions of the body on the way to a frame."""
        pairs = self._pairs(frame, self._known(frame))
        found = (self._steps.get(pair, (None, None))[1] for pair in pairs)
        return tuple(step for step in found if step is not None)

    def _to_follow(self, frame: int) -> tuple[Click, ...]:
        """Clicks not followed to a frame yet, of landmarks that are open there."""
        clicked = self._clicked_in(frame)
        told = told_by(self._steps_to(frame), frame)
        return tuple(
            one
            for one in self._nearest(frame)
            if one.landmark not in told
            and (one.key, one.position, frame) not in self._followed
            and ClickKey(frame, one.camera, one.landmark) not in clicked
        )

    def _clicked_in(self, frame: int) -> frozenset[ClickKey]:
        project = self._project.project
        if frame == self._document.frame:
            return frozenset(self._annotating.clicks())
        return frozenset(one.key for one in project.clicks.at(frame)) if project else frozenset()

    def _nearest(self, frame: int) -> tuple[Click, ...]:
        """Clicks of the nearest clicked frames on both sides of a frame."""
        known = [*self._clicks_around(), *self._annotating.clicks().values()]
        frames = {one.frame for one in known}
        before = max((one for one in frames if one < frame), default=frame)
        after = min((one for one in frames if one > frame), default=frame)
        near = {one for one in (before, after) if 0 < abs(frame - one) <= MOST_FRAMES}
        return tuple(one for one in known if one.frame in near and one.position is not None)

    def _found(self, frame: int) -> tuple[Prediction, ...]:
        keys = [(one.key, one.position, frame) for one in self._nearest(frame)]
        return tuple(p for key in keys if (p := self._followed.get(key)) is not None)

    def _question(self) -> ProposalQuestion | None:
        recording, frame = self._document.recording, self._document.frame
        if recording is None or not self._wanted():
            return None
        around, own = self._clicks_around(), self._annotating.used_clicks()
        names = {one.camera for one in (*around, *own)} | set(self._annotating.shown_cameras())
        names -= self._annotating.unused()
        names &= frozenset() if recording.guessed else set(recording.cameras)
        if set(self._cameras) != names:  # cameras that are guessed place nothing in the world
            self._cameras = {n: one for n, one in recording.cameras.items() if n in names}
        project = self._project.project
        followed = (*self._found(frame), *self._detected(frame))
        return ProposalQuestion(
            frame, own, around, followed, self._cameras,
            self._annotating.landmark_set.names, recording.fps,
            project.click_sigmas() if project is not None else {},
            self._steps_to(frame), self.wanted_mm(),
        )  # fmt: skip

    def _detected(self, frame: int) -> tuple[Prediction, ...]:
        """Predictions of detectors in a frame, their sigmas enlarged as they tell only once."""
        project = self._project.project
        if project is None:
            return ()
        sources = project.keypoints.sources()
        kept = (one for one in project.predictions.at(frame) if one.source in sources)
        return told_once((*kept, *self.detections.at(frame)))

    def _clicks_around(self) -> tuple[Click, ...]:
        """Clicks of the clicked frames around the one that is shown, up to the next gap."""
        frame, project = self._document.frame, self._project.project
        if project is None:
            return ()
        if self._around is None or self._around[0] != frame:
            gaps = gaps_of(project)
            inside = any(frame in gap for gap in gaps)
            self._around = (frame, () if inside else clicks_around(project, frame, gaps)[1])
        return self._around[1]

    # ---- answers

    def _on_followed(self, way: _Way, found: tuple[Prediction, ...] | BodyStep | None) -> None:
        if way is not self._way or way.overtaken.is_set():
            return
        if way.start is not None:
            step = found if isinstance(found, BodyStep) else None
            self._steps[way.start, way.frame] = (_told(way.clicks, way.start), step)
        elif isinstance(found, tuple):
            by_key = {(one.camera, one.landmark): one for one in found}
            for one in way.clicks:
                place = by_key.get((one.camera, one.landmark))
                self._followed[one.key, one.position, way.frame] = place
        self._way = None
        self._follow_next()
        if way.frame == self._document.frame or way.start is not None:
            self.answer.ask()
        self._tell()

    def _on_not_followed(self, _way: object, error: Exception) -> None:
        self._way = None
        self._tell_failure(error)


def _told(clicks: Sequence[Click], frame: int) -> frozenset[str]:
    """Landmarks that clicks of a frame place: clicked in two images."""
    counts = Counter(one.landmark for one in clicks if one.frame == frame and one.position)
    return frozenset(name for name, count in counts.items() if count > 1)
