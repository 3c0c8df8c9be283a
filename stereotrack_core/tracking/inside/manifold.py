"""What a tracker on the manifold has told becomes a trace."""

from __future__ import annotations

from stereotrack_core.body.manifold import error_names
from stereotrack_core.tracking.inside import events
from stereotrack_core.tracking.inside.corrections import Method, Place, correction_of, points_of
from stereotrack_core.tracking.inside.searching import search_of
from stereotrack_core.tracking.inside.trace import Correction, FrameTrace, Points, Search
from stereotrack_core.tracking.inside.watched import Watched
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.tracker import PersonTracker

SOUGHT = (
    "Nobody was followed in the frame before, so the person was looked for without help; the steps "
    "begin with the pose that was found."
)
ANEW = (
    "Another pose took the lead in this frame, as it explains the last frames better; the steps "
    "begin with it."
)
WIDENED = (
    "The data moved the body farther than was expected, so the frame was followed a second time "
    "from a wider prior."
)


def manifold_trace(tracker: PersonTracker, watched: Watched) -> FrameTrace:
    """Take a step of a tracker on the manifold, or of a peer, apart."""
    reader = _Reader(tracker, watched)
    for (_, event), pause in zip(watched.told, watched.pauses(), strict=True):
        reader.read(event, pause)
    estimate, p = watched.estimate, tracker.setup.parameters
    return FrameTrace(
        frame=watched.frame,
        method="manifold" if p.estimator == "iterated" else p.estimator,
        body=tracker.setup.body,
        state_names=error_names(tracker.setup.joints),
        before=reader.before,
        predicted=reader.predicted,
        after=Belief(estimate.pose, estimate.P),
        corrections=tuple(reader.corrections),
        estimate=estimate,
        refinements=tuple(tuple(each) for each in reader.refinements),
        measured=tuple(reader.measured) if not reader.corrections else (),
        search=reader.search,
        notes=tuple(reader.notes),
        seconds=reader.seconds | {"judge": watched.rest},
    )


class _Reader:
    """Reads events one by one."""

    def __init__(self, tracker: PersonTracker, watched: Watched) -> None:
        self.tracker = tracker
        self.before = self.predicted = watched.start
        self.notes: list[str] = []
        self.seconds: dict[str, float] = {}
        self._method = Method.of(tracker)
        self._passes = 0
        self._begin()

    def _begin(self) -> None:
        self.corrections: list[Correction] = []
        self.refinements: list[list[Correction]] = []
        self.measured: list[Points] = []
        self.search: Search | None = None
        self._stage, self._into = "follow", self.corrections
        self._corresponded: tuple[events.Corresponded, float] | None = None
        self._correcting: tuple[events.Correcting, float] | None = None
        self._searching: events.Searching | None = None
        self._refining: events.Refining | None = None
        self._proposed: list[events.Proposed] = []
        self._tried: list[tuple[events.Refining, events.Refined]] = []
        self._search_seconds = 0.0

    def read(self, event: events.Event, pause: float) -> None:
        """Take in one event that came so many seconds after the one before."""
        self._search_seconds += pause
        match event:
            case events.Sought():
                self.notes.append(SOUGHT)
                self._count("look for the person", pause)
            case events.Predicted():
                self._predict(event, pause)
            case events.Corresponded(_, surface):
                self._corresponded = (event, pause)
                self.measured = [*self.measured[:1], points_of(surface)]
            case events.Correcting():
                self._correcting = (event, pause)
            case events.Corrected():
                self._correct(event, pause)
            case events.Widened():
                self.notes.append(WIDENED)
                self._stage = "again"
            case _:
                self._read_search(event, pause)

    def _read_search(self, event: events.Event, pause: float) -> None:
        match event:
            case events.Searching():
                self._searching, self._search_seconds = event, pause
            case events.Proposed():
                self._proposed.append(event)
            case events.Refining():
                self._refining, self._stage = event, "refine"
                self._into = []
                self.refinements.append(self._into)
            case events.Refined():
                if self._refining is not None:
                    self._tried.append((self._refining, event))
            case events.Searched():
                self._finish_search(event)

    def _predict(self, event: events.Predicted, pause: float) -> None:
        self._passes += 1
        if self._passes > 1:
            self._begin()
            self.notes.append(ANEW)
        self.before = Belief(event.before.pose, event.before.P)
        self.predicted = Belief(event.pose, event.P)
        self._count("predict", pause)

    def _correct(self, done: events.Corrected, pause: float) -> None:
        if self._corresponded is None or self._correcting is None:
            return
        (pairs, looked), (told, gathered) = self._corresponded, self._correcting
        iteration = 1 + sum(each.stage == self._stage for each in self._into)
        place = Place(self._stage, iteration, looked, gathered + pause)
        self._into.append(correction_of(self._method, pairs.data, told, done, place))
        if self._stage != "refine":
            self._count("find partners", looked)
            self._count("correct", gathered + pause)

    def _finish_search(self, done: events.Searched) -> None:
        if self._searching is None:
            return
        self.search = search_of(
            self.tracker.setup.body,
            self.tracker.setup.parameters,
            self._searching,
            self._proposed,
            self._tried,
            done,
            self._search_seconds,
        )
        self._count("search for the arms", self._search_seconds)

    def _count(self, step: str, seconds: float) -> None:
        self.seconds[step] = self.seconds.get(step, 0.0) + seconds
