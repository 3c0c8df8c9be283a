"""How things are, in one line of words."""

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QObject
from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar

from stereotrack_core.counting import counted, spread_words
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import TrackedFrame

from ..context import Context
from ..session.changes import RECORDING
from ..session.judgement import UNCERTAIN_DEG, USUAL_RESIDUAL, USUAL_UNEXPLAINED, Judgement, doubts
from ..session.runs import RunEntry
from ..session.session import Session
from ..widgets.style.building import tool_button
from ..widgets.style.colours import limb_words

_NAMED = 2


def status_words(session: Session, doing: str) -> str:
    """One sentence about the recording, the tracker and the frame, and what is being done."""
    document = session.document
    if document.opening:
        words = "opening recording …"
    elif document.recording is None:
        words = "no recording is open"
    elif document.frame_count == 0:
        words = "the recording has no frame that is present in all streams"
    else:
        words = _tracker_words(session, document.recording)
    return f"{words}   ·   {doing}" if doing else words


def _tracker_words(session: Session, recording: Recording) -> str:
    def words(tracked: TrackedFrame, of: RunEntry | None) -> str:
        return frame_words(tracked, session.judging.of(of))

    frame, track, active = session.document.frame, session.track, session.runs.active
    live, shown = track.live, active.at(frame) if active is not None else None
    if live is not None:
        entry = live.entry
        done, wanted = len(entry.frames), len(entry.wanted)
        verb = "tracking" if track.running else "paused at"
        if done == 0 and track.running:
            return f"{verb} {done} of {wanted}: {live.preparing_words()}"
        if done == 0:
            return "paused before the first frame"
        newest = entry.frames[max(entry.frames)]
        told = words(shown, active) if shown is not None else words(newest, entry)
        left = (live.preparing_words() or live.left_words()) if track.running else ""
        if entry.heading is not None and entry.heading.undecided:
            left = _joined(left, "direction of the person undecided") if left else left
        return _joined(_joined(f"{verb} {done} of {wanted}", left), told)
    if active is not None and shown is not None:
        return _joined(f"frame {frame}, run “{active.name}”", words(shown, active))
    if active is not None:
        return f"run “{active.name}” does not contain frame {frame}"
    count = session.document.frame_count
    length = f"{counted(count, 'frame')}, {count / recording.fps:.1f} s"
    deep = any(view.kind != "mono" for view in recording.views)
    state = "not tracked yet" if deep else "no view provides depth"
    return f"{recording.name}: {length}; {state}"


def frame_words(tracked: TrackedFrame, judgement: Judgement | None = None) -> str:
    """What is known about one tracked frame: its errors, or else what speaks against its limbs.

    The filter's covariance is what the filter expects if it follows the right thing. It is never
    taken for a sign that it does.
    """
    if not tracked.tracked:
        return f"not tracked: {tracked.reason}"
    errors = judgement.errors_at(tracked.frame) if judgement is not None else {}
    if errors:
        return _error_words(tracked, errors)
    unsure = doubts(tracked)
    if unsure:
        return _some([f"{limb_words(limb)} {words}" for limb, words in unsure.items()])
    if not np.isfinite(tracked.estimate.limb_lost).any():
        sigma = tracked.estimate.limb_sigma_deg
        known = sigma[np.isfinite(sigma)]
        widest = spread_words(known.max(), digits=0) if len(known) else ""
        return _joined("failure not assessed", widest and f"at most ± {widest} (filter estimate)")
    against = _against(tracked)
    return f"no limb flagged, but {' and '.join(against)}" if against else "no limb flagged"


def _error_words(tracked: TrackedFrame, errors: Mapping[str, float]) -> str:
    """How far the limbs are off the reference, and whether the tracker has noticed."""
    unsure = doubts(tracked)
    far = [limb for limb in errors if errors[limb] > UNCERTAIN_DEG]
    if not far:
        flagged = [f"{limb_words(limb)} {words}" for limb, words in unsure.items()]
        told = f"limbs within {np.ceil(max(errors.values())):.0f}° of the reference"
        return _joined(told, _some(flagged) if flagged else "")
    said = [
        f"{limb_words(limb)} {errors[limb]:.0f}° off the reference,"
        f" {unsure.get(limb, 'not flagged')}"
        for limb in sorted(far, key=lambda limb: -errors[limb])
    ]
    return _some(said, "; ")


def _against(tracked: TrackedFrame) -> list[str]:
    found = []
    unexplained, residual = tracked.estimate.unexplained_fraction, tracked.estimate.residual
    if not np.isfinite([unexplained, residual]).all():
        found.append("the fit of the model to the points is not known")
    if unexplained > USUAL_UNEXPLAINED:
        found.append(f"{100.0 * unexplained:.0f} % of the points are unexplained")
    if residual > USUAL_RESIDUAL:
        found.append(f"points are {1000.0 * residual:.0f} mm off the model")
    return found


def _some(words: Sequence[str], between: str = ", ") -> str:
    more = len(words) - _NAMED
    return between.join(words[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def _joined(first: str, second: str) -> str:
    return f"{first}, {second}" if second else first


class StatusLine(QObject):
    """Follows the session and the tasks."""

    def __init__(self, bar: QStatusBar, context: Context) -> None:
        super().__init__(bar)
        self._context = context
        self.state, self.pixel = QLabel(), QLabel()
        self.state.setIndent(8)
        self.state.setMinimumWidth(1)  # long words are cut off; they never widen the window
        self.progress = QProgressBar(textVisible=False)
        self.progress.setMaximumSize(160, 14)
        tip, cancel = "Cancel the background tasks", context.tasks.cancel_all
        self.cancel = tool_button(tip, "stop", do=cancel)
        bar.addWidget(self.state, 1)
        for widget in (self.pixel, self.progress, self.cancel):
            bar.addPermanentWidget(widget)
        self.progress.hide()
        self.cancel.hide()
        context.docks.views.hovered.connect(self.pixel.setText)
        context.actions.refreshed.connect(self.write)
        context.session.changes.watch(RECORDING, self.pixel.clear)

    def write(self) -> None:
        session, tasks = self._context.session, self._context.tasks.tasks
        track = session.track
        doing = "; ".join(task.says() for task in tasks)
        words = status_words(session, doing)
        drawing = self._context.view_state.drawing
        if drawing is not None and drawing.frame == session.document.frame:
            words = f"step trace of frame {drawing.frame}: {drawing.words}"
        self.state.setText(words)
        entry = track.entry
        self.cancel.setVisible(bool(tasks))
        self.progress.setVisible(bool(tasks) or entry is not None)
        if tasks:
            share = tasks[0].share
            self.progress.setRange(0, 100 if share else 0)
            self.progress.setValue(round(100 * share))
        elif entry is not None:
            preparing = track.running and not entry.frames
            preparing_share = track.live.preparing_share if track.live is not None else 0.0
            done = 100 * preparing_share if preparing else len(entry.frames)
            self.progress.setRange(0, 100 if preparing else len(entry.wanted))
            self.progress.setValue(round(done))
