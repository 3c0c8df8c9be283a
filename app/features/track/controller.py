"""Track: the tracker, the panel of runs, their comparison, and the numbers of one frame."""

from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from weakref import ref

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import counted, in_words, spread_words
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import RunFacts
from stereotrack_core.tracking.frame import TrackedFrame

from ...context import Context
from ...services.actions import Command, Menu
from ...services.docks import Workspace
from ...session.changes import RECORDING, Part
from ...session.judgement import (
    TORSO_POSITION,
    UNCERTAIN_DEG,
    Against,
    arms_mean,
    doubts,
    measure_of,
    score_words,
    with_quality,
)
from ...session.messages import Message
from ...session.runs import RunEntry
from ...session.session import Session, Snapshot, unless
from ...session.tracking import FIRST_POSES
from ...widgets.style.colours import limb_words
from ...widgets.tables.panels import ComparisonPanel, NumberRow, NumbersPanel, RunRow, RunsPanel
from ...widgets.tables.table import Cell
from .comparison import compared, compared_stretches, shown_beside_each_other
from .keeping import RunKeeper

_AGAINST = "errors_against"
_AS_IT_DID = (
    "A failure that comes of earlier frames may be gone. To track the selection with that run's "
    "covariance, seed and background as well, choose As that run did."
)
_DETECTOR_HELPS = "A pose detector tells front from back: Track, Install pose detector …"


class RunsController:
    """Connects runs with the project, the panels and the commands."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        docks = context.docks
        self.keeper = RunKeeper(context)
        runs = context.session.runs
        self.panel = RunsPanel(
            lambda i: runs.activate(runs.entries[i]),
            lambda i, shown: runs.show(runs.entries[i], visible=shown),
            lambda i, name: self.keeper.rename(runs.entries[i], name),
        )
        self.numbers = NumbersPanel()
        self.comparison = ComparisonPanel()
        docks.add("runs", "Runs", self.panel)
        docks.add("numbers", "Frame metrics", self.numbers)
        docks.add("comparison", "Comparison", self.comparison)
        self._project: Project | None = None
        self._compared: object = None
        """Runs, reference and selection that the numbers belong to."""
        self._finished: RunEntry | None = None
        context.show(Part.JUDGEMENT | RECORDING, self._show_runs)
        numbers = Part.JUDGEMENT | Part.FRAME | RECORDING
        context.show(numbers, lambda now: self.numbers.show_rows(number_rows(now)), "numbers")
        chosen = Part.JUDGEMENT | Part.SELECTION | RECORDING | Part.SCENARIOS
        context.show(chosen, self._show_comparison, "comparison")
        tell = partial(context.session.changes.tell, Part.SCENARIOS)
        self.comparison.by_stretch.toggled.connect(tell)
        context.session.changes.hear(Part.RUN_ENDED, self._on_finished)
        context.session.changes.watch(Part.PROJECT_OPENED, self._on_project)
        context.tasks.watch(self.keeper.settled)

    def _show_runs(self, now: Snapshot) -> None:
        self.panel.show_rows([self.row(now, entry) for entry in now.runs])
        entry = self._finished
        if entry is None or not self._session.judging.settled():
            return
        self._finished, judgement = None, now.judgements.get(entry)
        score = score_words(judgement)
        known = judgement is not None and judgement.measure == "error"
        whose = "off by" if known else "with a filter uncertainty of"
        arms = f", arms {whose} {score} (mean)" if score else ""
        frames = counted(len(entry.frames), "frame")
        self._context.notifier.say(f"{entry.name}: {frames} tracked{arms}.", 8000)

    def _on_finished(self, entry: RunEntry) -> None:
        self._finished = entry  # and is said when it is judged

    def _on_project(self) -> None:
        project = self._session.project.project
        if project is not self._project:
            self._project = project
            stored = project.view_settings.get(_AGAINST) if project is not None else None
            self._session.judging.judge_against("project" if stored == "project" else None)

    def judge_against(self, against: Against) -> None:
        project = self._session.project.project
        if project is not None and not project.read_only:
            project.view_settings.set(_AGAINST, against)
        self._session.judging.judge_against(against)
        self._context.actions.refresh_soon()

    def run_selection(self) -> None:
        """Track the selection; offer the state of the run whose pose it begins with."""
        session, stretch = self._session, self._session.view_state.selection
        start = session.track.run_selection()
        if start is None or stretch is None or session.not_tried():
            return
        do = partial(session.trials.run_as, start.run, stretch)
        what = f"the initial pose is {start.words}"
        where = session.track.name_of(session.track.settings)
        self._context.notifier.show(Message("note", what, where, _AS_IT_DID, "As that run did", do))

    def row(self, now: Snapshot, entry: RunEntry) -> RunRow:
        facts, hint, active = self.keeper.facts(entry), self._hint(entry), entry is now.active
        seconds = entry.wall_seconds or (facts.wall_seconds if facts is not None else None)
        texts = (
            in_words(seconds) if seconds else "",
            "" if facts is None or facts.seed is None else str(facts.seed),
            _when(facts.made) if facts is not None else "",
        )
        others = (_frames(now, entry, facts), hint), _score(now, entry), *((t, hint) for t in texts)
        return RunRow(
            Cell(entry.name, hint, bold=active, ticked=entry.visible, editable=True),
            now.styles[entry], tuple(Cell(text, tip, bold=active) for text, tip in others),
            _made(now, entry, facts),
        )  # fmt: skip

    def _hint(self, entry: RunEntry) -> str:
        words = entry.heading
        heading = f" The direction that the person faces is {words.brief}." if words else ""
        fps = entry.frames_per_second() if entry.frames else None
        speed = f" {fps:.1f} frames per second." if fps is not None else ""
        place = f" From {entry.path}." if entry.path is not None else ""
        if entry.waiting and not entry.visible:
            place += " Check it to load it from the project."
        kept = self.keeper.why_not_kept(entry) or "Stored in the project."
        return f"{kept}{heading}{place}{speed} Press F2 to rename it."

    def with_active(self, do: Callable[[RunEntry], None]) -> None:
        """Do something with the active run, where there is one; say why it cannot be done."""
        active = self._session.runs.active
        if active is not None:
            self._context.notifier.attempt(lambda: do(active))

    def why_not_keep(self) -> str:
        active = self._session.runs.active
        if active is not None and active.kept:
            return "The run is already stored in the project."
        if active is not None and active is self._session.track.entry:
            return "The run is stored automatically when it is complete."
        return ""

    def _show_comparison(self, now: Snapshot) -> None:
        shown = shown_beside_each_other(now)
        runs = tuple((ref(one), one.name, len(one.frames)) for one in shown)
        segments, by = self._session.segments(), self.comparison.by_stretch
        by.setVisible(bool(segments) and now.judgement is not None)
        segments = segments if by.isChecked() else ()
        key = runs, now.truth, now.selection, segments
        if now.judgement is None:
            self.comparison.show_numbers("", (), ())
        elif key != self._compared:
            if segments:
                found = compared_stretches(shown, now.judgement, segments)
            else:
                found = compared(shown, now.judgement, now.selection)
            self.comparison.show_numbers(found.words, found.runs, found.rows, found.how)
        self._compared = key


_FIRST_POSES = {
    **{name: title[0].lower() + title[1:] for name, (title, _tip) in FIRST_POSES.items()},
    "tpose": "a T pose",
    "pose": "given",
}


def _score(now: Snapshot, entry: RunEntry) -> tuple[str, str]:
    """Score of a run over the frames of the active one, with the difference, and a tip."""
    found, other = now.judgements.get(entry), now.judgement
    if found is None or other is None or found is other:
        words = score_words(found).replace("reference uncertainty", "±")
        return words, "Over all frames of the run." if words else ""
    frames = np.intersect1d(found.frame, other.frame)
    score, active = arms_mean(found, frames), arms_mean(other, frames)
    if not np.isfinite(score - active) or found.measure != other.measure:
        return "–", "Not compared: there is no frame in which both are known."
    part = f" in {counted(len(frames), 'frame')}" if len(frames) < len(found.frame) else ""
    return f"{score:.1f}° ({score - active:+z.1f}){part}", (
        f"Over {counted(len(frames), 'frame')} that the run and the active run share. In brackets "
        "the difference from the active run; lower is better."
    )


def _frames(now: Snapshot, entry: RunEntry, facts: RunFacts | None) -> str:
    if entry is now.in_progress:
        return f"{len(entry.frames)} of {len(entry.wanted)}"
    numbers = entry.numbers()
    if len(numbers):
        return f"{numbers[0]} – {numbers[-1]}"
    if facts is not None and facts.first is not None:
        return f"{facts.first} – {facts.last}"
    return "none yet"


def _made(now: Snapshot, entry: RunEntry, facts: RunFacts | None) -> str:
    if facts is None:
        return f"Preset {entry.preset or 'unknown'}; in progress."
    changed = facts.changed_words
    words = [f"Preset {facts.preset or 'unknown'}{f', {changed}' if changed else ''}"]
    if facts.views:
        words.append(f"views {'+'.join(facts.views)}")
    words.append(f"initial pose {_FIRST_POSES.get(facts.init, facts.init or 'unknown')}")
    if facts.smoothed:
        words.append("smoothed")
    if facts.detector:
        words.append(f"pose detector {facts.detector}")
    helps = now.settings.uses_detector and not facts.detector
    hint = f"\n{_DETECTOR_HELPS}" if helps and not is_installed() else ""
    return f"{'; '.join(words)}.{hint}"


def _when(made: str) -> str:
    """When a run was tracked, by the clock here: the hour today, else the day."""
    try:
        then = datetime.fromisoformat(made).astimezone()
    except ValueError:
        return ""
    today = datetime.now(UTC).astimezone().date()
    return f"{then:%H:%M}" if then.date() == today else f"{then:%Y-%m-%d}"


def number_rows(now: Snapshot) -> list[NumberRow]:
    """Rows of the numbers panel."""
    tracked, judgement = now.tracked, now.judgement
    if tracked is None:
        return []
    frame, estimate, rows = tracked.frame, tracked.estimate, list[NumberRow]()
    quality = {} if judgement is None else judgement.quality_over(np.array([frame]))
    angles = {} if judgement is None else judgement.errors_at(frame)
    unsure = doubts(tracked)
    for limb, sigma, chance in zip(LIMBS, estimate.limb_sigma_deg, estimate.limb_lost, strict=True):
        value = spread_words(sigma)
        value = f"± {value}" if value != "unknown" else value
        error = angles.get(limb)
        if error is not None:
            stated = with_quality(f"{error:.1f}°", quality.get(measure_of(limb)))
            value = f"{stated}  ({value})"
        missed = "far off, not flagged" if error is not None and error > UNCERTAIN_DEG else ""
        remarks = [unsure.get(limb, missed)]
        if chance == chance:
            remarks.append(f"failure probability {100.0 * chance:.0f} %")
        rows.append((limb, limb_words(limb), value, ", ".join(filter(None, remarks))))
    errors = None if judgement is None else judgement.errors
    for off in () if errors is None else errors.torso_position[errors.frame == frame]:
        value = with_quality(f"{1000.0 * off:.0f} mm", quality.get(TORSO_POSITION), digits=0)
        hint = "Distance of the hip midpoint from the reference."
        rows.append(("torso", "torso position", value, hint))
    return [*rows, *_frame_rows(tracked)]


def _frame_rows(tracked: TrackedFrame) -> list[NumberRow]:
    estimate = tracked.estimate
    if not tracked.tracked:
        return [("", "not tracked", tracked.reason, "Why this frame has no pose.")]
    stages = ", ".join(f"{name} {1000.0 * value:.0f} ms" for name, value in tracked.seconds.items())
    hint = f"Stages: {stages}. Processing of consecutive frames overlaps."
    time = ("", "time", f"{1000.0 * sum(tracked.seconds.values()):.0f} ms", hint)
    if not np.isfinite(estimate.unexplained_fraction):
        none = "Without depth there is no cloud. The pose is measured by keypoints and contours."
        return [("", "points", "none", none), time]
    return [
        ("", "unexplained fraction", f"{100.0 * estimate.unexplained_fraction:.1f} %",
         "Fraction of the measured points that the model does not explain; 0 is ideal."),
        ("", "residual", f"{1000.0 * estimate.residual:.1f} mm",
         "Weighted root mean square distance between points and model."),
        ("", "normalised innovation", f"{estimate.innovation:.2f}",
         "Distance of the points from the prediction, relative to its predicted standard "
         "deviation; 1 is expected."),
        time,
    ]  # fmt: skip


_REFERENCES: dict[Against, tuple[str, str]] = {
    "recording": (
        "Recording's reference",
        "Measure errors against the reference that comes with the recording.",
    ),
    "project": (
        "Project's reference",
        "Measure errors against the trajectory fitted to the clicks, and state its accuracy.",
    ),
}


def register(context: Context) -> RunsController:
    """Offer the workspace Track, its panels and its commands."""
    runs = RunsController(context)
    space = Workspace(
        "track", "Track", "Run the tracker and watch it: views, 3-D scene, settings and runs.",
        "run-tracker",
        side=(("scene",), ("runs", "parameters", "numbers", "inside", "findings")),
        bottom=("plot", "timeline"), side_share=0.37, bottom_shares=(0.15, 0.17),
        side_heights=(2, 1), why_not=context.session.not_tracked,
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(context, runs))
    return runs


def _commands(context: Context, runs: RunsController) -> list[Command]:
    session = context.session
    track, keypoints, shown = session.track, session.keypoints, session.runs

    def idle() -> str:
        return session.not_tracked() or session.tracker_works()

    command = Menu("&Track").command
    first_poses = [
        Menu("&Track/Initial pose", session.no_depth).command(
            f"first_pose_{name.replace(' ', '_')}", title, tip,
            partial(setattr, track, "first_pose", name),
            checked=lambda name=name: track.first_pose == name,
        )
        for name, (title, tip) in FIRST_POSES.items()
    ]  # fmt: skip
    return [
        command("run", "Run", "Track the recording from the first frame, or resume a paused run.",
                track.run, "F8", "run-tracker", why_not=idle),
        command("pause", "Pause", "Pause the tracker after the current frame.", track.pause,
                "Shift+F8", "pause",
                why_not=lambda: unless(track.running, "The tracker is not running.")),
        command("step", "Track one frame", "Track one frame, then pause.", track.step, "F10",
                "step-tracker", why_not=idle),
        command("stop", "Stop run", "Stop the run in progress and keep the frames tracked so far.",
                track.stop, "Ctrl+.", "stop",
                why_not=lambda: unless(track.entry, "No run is in progress.")),
        command("run_here", "Run from current frame", "Start a new run at this frame, from the "
                "pose of the active run if it has one here.", track.run_from_here, "Ctrl+F8",
                "next", why_not=idle, section=True),
        command("run_selection", "Run on selection", "Track the selected frames as a new run.",
                runs.run_selection, "Ctrl+Shift+F8", "selection",
                why_not=lambda: idle() or unless(context.view_state.selection, "No frames are "
                "selected. Select some in the timeline with Shift+drag.")),
        *first_poses,
        command("use_keypoints", "Use keypoints", "Track the next run with the keypoints that a "
                "detector has predicted, beside the point cloud or, in mono views, in its place.",
                keypoints.toggle, why_not=lambda: session.no_project() or keypoints.why_none(),
                checked=lambda: keypoints.wanted),
        command("follow", "Follow tracker", "Show each frame as soon as it is tracked, except in "
                "Annotate.",
                lambda: setattr(track, "follow", not track.follow), "F",
                checked=lambda: track.follow),
        command("hide_run", "Show active run", "Show or hide the model and the curves of the "
                "active run.", shown.toggle_active, "H", "model", why_not=session.no_run,
                section=True),
        command("next_run", "Next run", "Make the next run the active one.",
                shown.activate_next, "T", "compare", why_not=lambda: session.no_run()
                or unless(len(shown.entries) > 1, "There is only one run.")),
        command("last_run", "Blink runs", "Make the run active that was active before; again and "
                "again, two runs blink.", shown.activate_last, "Shift+T", "compare",
                why_not=lambda: session.no_run()
                or unless(len(shown.entries) > 1, "There is only one run.")),
        command("keep_run", "Store run in project", "Store a run that was opened from a file in "
                "the project. Runs tracked here are stored automatically.",
                partial(runs.with_active, runs.keeper.keep), icon="save",
                why_not=lambda: session.no_run() or session.no_edit() or runs.why_not_keep()),
        command("remove_run", "Remove run", "Remove the active run from the list and from the "
                "project; Restore run brings it back. Files are not deleted.",
                partial(runs.with_active, runs.keeper.remove), "Ctrl+Del", "delete",
                why_not=lambda: session.no_run() or unless(
                    session.runs.active is not track.entry,
                    "This run is in progress. Stop it first.")),
        command("restore_run", "Restore run", "Bring back the run that was removed last from the "
                "project.", runs.keeper.restore, icon="undo",
                why_not=lambda: session.no_edit() or unless(
                    runs.keeper.removed, "No run was removed from the project.")),
        *_against(session, runs),
    ]  # fmt: skip


def _against(session: Session, runs: RunsController) -> list[Command]:
    def why_not(against: Against) -> str:
        if session.no_recording() or session.judging.has(against):
            return session.no_recording()
        if against == "recording":
            return "This recording has no reference."
        return "The whole recording has not been fitted yet. Choose Fit whole recording first."

    def measured(against: Against) -> bool:
        return session.judging.truth is not None and session.judging.truth.against == against

    command = Menu("&Track/Errors against").command
    return [
        command(f"errors_against_{against}", text, tip, partial(runs.judge_against, against),
                icon="reference", why_not=partial(why_not, against),
                checked=partial(measured, against))
        for against, (text, tip) in _REFERENCES.items()
    ]  # fmt: skip
