"""The panel of runs, their comparison, and the numbers of one frame."""

from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from typing import TypeAlias
from weakref import ref

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import counted, spread_words
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import RunFacts
from stereotrack_core.tracking.frame import TrackedFrame

from ...context import Context
from ...session.changes import RECORDING, Part
from ...session.comparison import ComparedRuns, compared, shown_beside_each_other
from ...session.judgement import (
    TORSO_POSITION,
    UNCERTAIN_DEG,
    Against,
    Judgement,
    doubts,
    measure_of,
    score_words,
    with_quality,
)
from ...session.runs import RunEntry
from ...session.tracker import FIRST_POSES
from ...widgets.style.colours import limb_words
from ...widgets.tables.panels import NumbersPanel
from ...widgets.tables.runs_panel import ComparisonPanel, RunRow, RunsPanel
from .keeping import RunKeeper

_AGAINST = "errors_against"
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
        self._compared: tuple[object, ComparedRuns] | None = None
        self._finished: RunEntry | None = None
        self._connect()
        context.tasks.watch(self.keeper.settled)

    def _connect(self) -> None:
        session = self._session
        watch, soon = session.changes.watch, self._context.docks.redraw.soon
        watch(Part.JUDGEMENT, partial(soon, self._show_runs))
        watch(Part.JUDGEMENT | Part.FRAME, partial(soon, self._show_numbers))
        watch(Part.JUDGEMENT, partial(soon, self.show_comparison))
        watch(RECORDING, self.show)
        session.changes.hear(Part.RUN_ENDED, self._on_finished)
        watch(Part.PROJECT_OPENED, self._on_project)
        watch(Part.SELECTION, self.show_comparison)

    # ---- following

    def show(self) -> None:
        self._show_runs()
        self._show_numbers()
        self.show_comparison()

    def _show_runs(self) -> None:
        self.panel.show_rows([self.row(entry) for entry in self._session.runs.entries])
        if self._finished is not None and self._session.judging.settled():
            self._say_how_it_ended(self._finished)
            self._finished = None

    def _show_numbers(self) -> None:
        active = self._session.runs.active
        tracked = active.at(self._session.document.frame) if active is not None else None
        self.numbers.show_rows(number_rows(tracked, self._session.judging.of(active)))

    def _on_finished(self, entry: RunEntry) -> None:
        self._finished = entry  # and is said when it is judged

    def _say_how_it_ended(self, entry: RunEntry) -> None:
        judgement = self._session.judging.of(entry)
        score = score_words(judgement)
        known = judgement is not None and judgement.measure == "error"
        whose = "off by" if known else "with a filter uncertainty of"
        arms = f", arms {whose} {score} (median)" if score else ""
        frames = counted(len(entry.frames), "frame")
        self._context.notifier.say(f"{entry.name}: {frames} tracked{arms}.", 8000)

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

    # ---- the list

    def row(self, entry: RunEntry) -> RunRow:
        judgement, facts = self._session.judging.of(entry), self.keeper.facts(entry)
        seconds = entry.wall_seconds or (facts.wall_seconds if facts is not None else None)
        return RunRow(
            name=entry.name, style=self._session.runs.style(entry), visible=entry.visible,
            active=entry is self._session.runs.active, frames=self._frames(entry, facts),
            score=score_words(judgement, short=True), hint=self._hint(entry),
            time=_duration(seconds),
            seed="" if facts is None or facts.seed is None else str(facts.seed),
            when=_when(facts.made) if facts is not None else "", made=self._made(entry, facts),
        )  # fmt: skip

    def _frames(self, entry: RunEntry, facts: RunFacts | None) -> str:
        if entry is self._session.track.entry:
            return f"{len(entry.frames)} of {len(entry.wanted)}"
        numbers = entry.numbers()
        if len(numbers):
            return f"{numbers[0]} – {numbers[-1]}"
        if facts is not None and facts.first is not None:
            return f"{facts.first} – {facts.last}"
        return "none yet"

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

    def _made(self, entry: RunEntry, facts: RunFacts | None) -> str:
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
        helps = self._session.track.settings.uses_detector and not facts.detector
        hint = f"\n{_DETECTOR_HELPS}" if helps and not is_installed() else ""
        return f"{'; '.join(words)}.{hint}"

    # ---- commands

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

    # ---- comparison

    def show_comparison(self) -> None:
        shown = shown_beside_each_other(
            self._session.runs.entries, self._session.runs.active, self._session.judging.all()
        )
        judgement = self._session.judging.of(shown[0]) if shown else None
        if judgement is None:
            self.comparison.show_numbers("", (), ())
            return
        found = self._found(shown, judgement)
        self.comparison.show_numbers(found.words, found.runs, found.rows, found.how)

    def _found(self, shown: tuple[RunEntry, ...], judgement: Judgement) -> ComparedRuns:
        selection = self._context.view_state.selection
        runs = tuple((ref(one), one.name, len(one.frames)) for one in shown)
        key = runs, judgement.truth, selection
        if self._compared is None or self._compared[0] != key:
            self._compared = (key, compared(shown, judgement, selection))
        return self._compared[1]


_FIRST_POSES = {
    **{name: title[0].lower() + title[1:] for name, (title, _tip) in FIRST_POSES.items()},
    "tpose": "a T pose",
    "pose": "given",
}


def _duration(seconds: float | None) -> str:
    if not seconds:
        return ""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min"


def _when(made: str) -> str:
    """When a run was tracked, by the clock here: the hour today, else the day."""
    try:
        then = datetime.fromisoformat(made).astimezone()
    except ValueError:
        return ""
    today = datetime.now(UTC).astimezone().date()
    return f"{then:%H:%M}" if then.date() == today else f"{then:%Y-%m-%d}"


_NumberRow: TypeAlias = tuple[str, str, str, str]  # limb, label, value and hint


def number_rows(tracked: TrackedFrame | None, judgement: Judgement | None) -> list[_NumberRow]:
    """Rows of the numbers panel."""
    if tracked is None:
        return []
    frame, estimate, rows = tracked.frame, tracked.estimate, list[_NumberRow]()
    quality = {} if judgement is None else judgement.quality_over(np.array([frame]))
    unsure = doubts(tracked)
    angles = judgement.errors_at(frame) if judgement is not None else {}
    for limb, sigma, chance in zip(LIMBS, estimate.limb_sigma_deg, estimate.limb_lost, strict=True):
        value = spread_words(sigma)
        value = f"± {value}" if value != "unknown" else value
        error = angles.get(limb)
        if error is not None:
            stated = with_quality(f"{error:.1f}°", quality.get(measure_of(limb)))
            value = f"{stated}  ({value})"
        if chance == chance:
            value += f", failure probability {100.0 * chance:.0f} %"
        missed = "far off, not flagged" if error is not None and error > UNCERTAIN_DEG else ""
        rows.append((limb, limb_words(limb), value, unsure.get(limb, missed)))
    errors = None if judgement is None else judgement.errors
    for off in () if errors is None else errors.torso_position[errors.frame == frame]:
        value = with_quality(f"{1000.0 * off:.0f} mm", quality.get(TORSO_POSITION), digits=0)
        hint = "Distance of the hip midpoint from the reference."
        rows.append(("torso", "torso position", value, hint))
    return [*rows, *_frame_rows(tracked)]


def _frame_rows(tracked: TrackedFrame) -> list[_NumberRow]:
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
