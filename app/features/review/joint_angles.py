"""Joint angles of runs and of the reference: worked out, drawn and tabled; degrees."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from weakref import WeakKeyDictionary

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.joint_angles.definitions import ANGLES
from stereotrack_core.evaluation.joint_angles.motion import (
    AngleRange,
    Motion,
    motion_of,
    stretch_motion,
)
from stereotrack_core.evaluation.joint_angles.series import (
    JointAngles,
    angles_of_reference,
    angles_of_run,
    angles_of_trajectory,
)
from stereotrack_core.recording.description import Segment

from ...services.tasks.task import TaskList
from ...session.runs import RunEntry, RunList
from ...session.truth import Truth
from ...widgets.plots.plots import Curve
from ...widgets.style.colours import LineStyle
from ...widgets.style.limb_colours import LIMB_COLOURS
from ...widgets.tables.table import Cell, CellRow
from .per_run import PerRun

_MORE = 1.25
"""A run that grows is worked out again when it has so many times the frames."""

QUANTITIES: tuple[tuple[str, str], ...] = (
    ("angle", "angle"),
    ("velocity", "velocity"),
    ("acceleration", "acceleration"),
)
"""What can be drawn of an angle: key and words."""

_UNITS = {"angle": "deg", "velocity": "deg/s", "acceleration": "deg/s²"}

COLUMNS: tuple[tuple[str, str], ...] = (
    ("range", "Range of motion: largest minus smallest angle, degrees"),
    ("mean", "Mean angle, degrees, ± root mean square of its standard deviation"),
    ("peak °/s", "Peak speed in either direction, degrees per second"),
    (
        "left − right",
        "Left minus right range of motion, degrees, and as a percentage of their mean",
    ),
)
"""Columns of the table of ranges."""


def choices() -> tuple[tuple[str, str, str], ...]:
    """Angles to choose from, left and right together: key, words, and what they mean."""
    found = {angle.kind: (angle.label, angle.meaning) for angle in ANGLES}
    arms_first = sorted(found, key=lambda kind: kind.startswith(("torso", "head")))
    return tuple((kind, *found[kind]) for kind in arms_first)


@dataclass(frozen=True, eq=False)
class Moved:
    """Angles with their derivatives."""

    name: str
    """The run, or the reference."""
    style: LineStyle
    """The run's line style, or that of the reference."""
    angles: JointAngles
    motion: Motion


class RunAngles:
    """Keeps the joint angles of runs and of the reference."""

    def __init__(
        self, runs: RunList, tasks: TaskList, growing: Callable[[], RunEntry | None]
    ) -> None:
        self._runs, self._growing = runs, growing
        self.known: PerRun[JointAngles] = PerRun(tasks, "computing joint angles")
        self._motions: WeakKeyDictionary[JointAngles, tuple[float, Motion]] = WeakKeyDictionary()

    def ask(self, truth: Truth | None) -> None:
        """Work out what is not known yet."""
        if truth is not None:
            self.known.ask(truth, True, partial(_of_truth, truth))
        for entry in self._runs.entries:
            count, before = len(entry.frames), self.known.asked(entry)
            least = 1
            if entry is self._growing():
                least = 8 + (int(_MORE * before) if isinstance(before, int) else 0)
            if count >= least and (entry.origin is not None or entry.stored is not None):
                self.known.ask(entry, count, partial(_of_run, entry.now()))

    def shown(self, truth: Truth | None, fps: float, cut_off: float) -> list[Moved]:
        """Angles of all runs that are shown, the active one first, then of the reference."""
        active = self._runs.active
        named: list[tuple[object, str, LineStyle]] = [
            (entry, entry.name, self._runs.style(entry))
            for entry in (active, *self._runs.shown_beside())
            if entry is not None
        ]
        if truth is not None:
            named.append((truth, "reference", "reference"))
        return [
            Moved(name, style, angles, self._motion(angles, fps, cut_off))
            for about, name, style in named
            if (angles := self.known.of(about)) is not None
        ]

    def _motion(self, angles: JointAngles, fps: float, cut_off: float) -> Motion:
        known = self._motions.get(angles)
        if known is None or known[0] != cut_off:
            known = self._motions[angles] = (cut_off, motion_of(angles, fps, cut_off))
        return known[1]


def _of_run(run: RunEntry, _task: object) -> JointAngles:
    made = run.run()
    assert made is not None  # noqa: S101 - it is known where it comes from
    return angles_of_run(made)


def _of_truth(truth: Truth, _task: object) -> JointAngles:
    if truth.reference is not None:
        return angles_of_reference(truth.reference)
    return angles_of_trajectory(truth.trajectory)


def curves_of(moved: Sequence[Moved], kind: str, quantity: str) -> tuple[Curve, ...]:
    """Curves of one angle, left and right; only the active run and the reference have bands."""
    curves = []
    for one in moved:
        value, sigma = _values(one, quantity)
        for k, angle in enumerate(ANGLES):
            if angle.kind != kind or not np.isfinite(value[:, k]).any():
                continue
            banded = one.style in {"solid", "reference"}
            curves.append(
                Curve(
                    one.name, angle.side or angle.limb, LIMB_COLOURS[angle.limb], one.style,
                    one.angles.frame, np.degrees(value[:, k]),
                    np.degrees(sigma[:, k]) if banded else None,
                )
            )  # fmt: skip
    return tuple(curves)


def unit_of(quantity: str) -> str:
    """Unit of what is drawn."""
    return _UNITS[quantity]


def plot_words(moved: Sequence[Moved], kind: str, quantity: str) -> str:
    """What is drawn, what is positive, and how it was made."""
    if not moved:
        return ""
    meaning = next(angle.meaning for angle in ANGLES if angle.kind == kind)
    said = f"{meaning[0].upper()}{meaning[1:]}. Band: one standard deviation."
    if quantity == "angle":
        return f"{said} Unsmoothed."
    motion = moved[0].motion
    limit = motion.words.removesuffix(".")
    return f"{limit}. Band: one standard deviation, assuming independent errors between frames."


def range_rows(moved: Moved, stretch: Segment) -> tuple[CellRow, ...]:
    """Rows of the table of ranges in a stretch, arms first."""
    found = stretch_motion(moved.angles, moved.motion, stretch)
    sides = {side.left.angle.name: side for side in found.sides}
    rows: dict[bool, list[CellRow]] = {False: [], True: []}
    for one in found.ranges:
        if not one.frames:
            continue
        difference = ""
        side = sides.get(one.angle.name)
        if side is not None and np.isfinite(side.difference):
            share = f" ({100.0 * side.symmetry:+z.0f} %)" if np.isfinite(side.symmetry) else ""
            difference = f"{np.degrees(side.difference):+z.1f}{share}"
        cells = (
            _with_sigma(one.range, one.range_sigma),
            _with_sigma(one.mean, one.sigma),
            _with_sigma(one.peak_velocity, one.peak_velocity_sigma, 0),
            difference,
        )
        label = one.angle.words.replace("shoulder ", "")  # whole in the tip
        hint, limb = _hint(one), one.angle.limb
        name = Cell(label, hint, swatch=LIMB_COLOURS[limb], value=one.angle.kind)
        rows[limb in {"torso", "head"}].append((name, *(Cell(text, hint) for text in cells)))
    return (*rows[False], *rows[True])


def table_words(moved: Moved, stretch: Segment) -> str:
    """What the table is of."""
    where = f"{stretch.name}, frames {stretch.first} – {stretch.end - 1}"
    return f"{moved.name}, {where}, degrees"


def _values(one: Moved, quantity: str) -> tuple[FloatArray, FloatArray]:
    motion = one.motion
    if quantity == "velocity":
        return motion.velocity, motion.velocity_sigma
    if quantity == "acceleration":
        return motion.acceleration, motion.acceleration_sigma
    return one.angles.angle, one.angles.sigma


def _with_sigma(value: float, sigma: float, digits: int = 1) -> str:
    if not np.isfinite(value):
        return "–"
    text = f"{np.degrees(value):.{digits}f}"
    return f"{text} ± {np.degrees(sigma):.{digits}f}" if np.isfinite(sigma) else text


def _hint(one: AngleRange) -> str:
    low, high = np.degrees([one.minimum, one.maximum])
    return (
        f"{one.angle.words}: from {low:.1f}° to {high:.1f}° in {one.frames} frames. "
        f"{one.angle.meaning[0].upper()}{one.angle.meaning[1:]}."
    )
