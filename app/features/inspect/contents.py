"""What the panel shows of one step."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARTS, limb_of_part
from stereotrack_core.evaluation.failure_segments.reasons import reason_of
from stereotrack_core.tracking.estimate import Correspondences
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.trace import (
    REASONS,
    Correction,
    Pair,
    Rows,
    Search,
    StepTrace,
    movement,
)

from ...session.inspection import Step, name_of
from ...widgets.plots.inside_panel import StepContent, Table
from ...widgets.style.colours import limb_words

_KINDS = {
    "elbow": "Elbow joint limits",
    "rest": "Head and legs at rest",
    "torso": "Arm–torso collisions",
    "arms": "Arm–arm collisions",
    "outline": "Silhouettes",
    "detection": "Keypoints",
}
_NEGATIVE = (
    "The prediction is the mean over the sigma points (2.16), which lies off the model where a "
    "joint is uncertain. A residual can therefore be negative although a distance cannot."
)
_REASONS = ("Hidden", "Inside", "Excess", "Too far", "On the cone")
_UNITS = {"m": ("mm", 1e3), "rad": ("°", float(np.degrees(1.0))), "px": ("px", 1.0)}

_LIMITS = "The true arms stand on the followed body. The tracker itself never sees them."
_COSTS = {
    "keypoints": ("Keyp.", "Elbows and wrists that are not where keypoints show them"),
    "data": ("Data", "Measured points that neither torso nor arms explain"),
    "anatomy": ("Anat.", "Elbows bent too far, arms inside the torso, implausible arm positions"),
    "change": ("Change", "Change from the predicted arms"),
    "crossing": ("Cross", "Arms that intersect each other"),
    "pictures": ("Views", "Parts of the pose that views should see and do not"),
}


def content_of(trace: StepTrace, step: Step, compared: str = "") -> StepContent:
    """One step in words and numbers; `compared` says how the result differs from a run's."""
    correction = trace.corrections[step.correction] if step.correction >= 0 else None
    match step.kind:
        case "predict":
            table = deviations_table(
                trace.before, trace.predicted, trace.state_names, ("Before", "Predicted")
            )
            return _content(step, trace, " ".join(trace.notes), tables=(table,))
        case "search":
            return _search(trace, step)
        case "collisions":
            return _collisions(trace, step)
        case "settle" | "result":
            return _result(trace, step, compared)
        case _ if correction is None:
            points = trace.measured[0]
            return _content(step, trace, _said(points), tables=(_parts_table(points),))
        case "points":
            return _content(step, trace, tables=(_points_table(correction),))
        case "pairs":
            return _pairs(trace, step, correction)
        case "sigma":
            return _sigma(trace, step, correction)
        case "cross":
            n, m = correction.P_xz.shape
            gain = f"norm of the gain {correction.gain_norm:.3g}"
            words = f"{n} states, {m} correspondences; {gain}."
            table = correlations_table(correction, trace.state_names)
            return _content(step, trace, words, tables=(table,))
        case _:
            return _correct(trace, step, correction)


def _content(step: Step, trace: StepTrace, words: str = "", **parts: object) -> StepContent:
    said = f"{step.words} {words}".strip()
    return StepContent(name_of(step, trace), said, step.source, **parts)  # type: ignore[arg-type]


def _points_table(correction: Correction) -> Table:
    used, unused = correction.points, correction.unused
    parts = np.unique(np.concatenate([used.part, unused.part[unused.part >= 0]])).tolist()
    reasons = np.unique(unused.why).tolist()

    def row(name: str, of_used: BoolArray, of_unused: BoolArray) -> tuple[str, ...]:
        chosen = (of_used, *(of_unused & (unused.why == why) for why in reasons))
        return (name, *(str(n) if (n := np.count_nonzero(one)) else "–" for one in chosen))

    rows = [row(part_words(part), used.part == part, unused.part == part) for part in parts]
    if np.any(unused.part < 0):
        rows.append(row("no part", np.zeros_like(used.part, bool), unused.part < 0))
    rows.append(row("all", np.ones_like(used.part, bool), np.ones_like(unused.part, bool)))
    limbs = (*map(limb_of_part, parts), *[""] * (len(rows) - len(parts)))
    said = tuple(_REASONS[why] for why in reasons)
    tips = ("", "Points that are used", *(_capital(REASONS[why]) for why in reasons))
    strong = (len(rows) - 1,)
    return Table("Points", ("Part", "Used", *said), tuple(rows), limbs, strong, tips)


def _pairs(trace: StepTrace, step: Step, correction: Correction) -> StepContent:
    points = correction.points
    if not len(points.residual):
        return _keypoints(trace, step, correction)
    residual = correction.normalised_residual
    words = f"{_said(points)} Normalised residual {residual:.2f}; 1 is expected."
    if trace.method == "thesis" and bool(np.any(points.residual < 0.0)):
        words = f"{words} {_NEGATIVE}"
    tables = [_parts_table(points)]
    if correction.rows:
        tables.append(_rows_table(correction.rows))
    return _content(step, trace, words, tables=tuple(tables))


def _keypoints(trace: StepTrace, step: Step, correction: Correction) -> StepContent:
    tables = [_rows_table(correction.rows)]
    for row in correction.rows:
        if row.kind == "detection" and row.unit == "px":
            tables.insert(0, _keypoints_table(row))
    return _content(step, trace, tables=tuple(tables))


def _keypoints_table(row: Rows) -> Table:
    """Keypoints of all cameras by the part that they measure; each has a column and a row."""
    distance = np.hypot(*row.residual.reshape(-1, 2).T)
    part, sigma = row.part[::2], row.sigma[::2]
    found, limbs = [], []
    for one in np.unique(part).tolist():
        own = part == one
        rms = f"{np.sqrt(np.mean(distance[own] ** 2)):.1f}"
        count = str(np.count_nonzero(own))
        found.append((part_words(one), count, rms, f"{sigma[own].mean():.1f}"))
        limbs.append(limb_of_part(one))
    columns = {
        "Part": "",
        "Keypoints": "Keypoints of all cameras that have weight",
        "RMS": "Root mean square of the distances from the body's points",
        "σ": "Assumed standard deviation of a coordinate; larger where the weight is small",
    }
    title, tips = "Keypoints by part, in pixels", tuple(columns.values())
    return Table(title, tuple(columns), tuple(found), tuple(limbs), tips=tips)


def _said(points: Correspondences) -> str:
    if not len(points.residual):
        return "No correspondences."
    rms = 1e3 * float(np.sqrt(np.mean(points.residual**2)))
    return f"{len(points.residual)} correspondences, root mean square {rms:.1f} mm."


def _parts_table(points: Correspondences) -> Table:
    rows, limbs = [], []
    for part in np.unique(points.part).tolist():
        own = points.part == part
        residual = 1e3 * points.residual[own]
        rows.append((
            part_words(part),
            str(np.count_nonzero(own)),
            f"{residual.mean():+z.1f}",
            f"{np.sqrt(np.mean(residual**2)):.1f}",
            f"{points.weight[own].mean():.2f}",
            f"{1e3 * points.sigma[own].mean():.0f}",
        ))  # fmt: skip
        limbs.append(limb_of_part(part))
    columns = {
        "Part": "",
        "Pairs": "Correspondences",
        "Mean": "Mean residual; positive: the measured points are ahead of their partners",
        "RMS": "Root mean square of the residuals",
        "Weight": "1: full weight, 0: none. The weight falls with the distance.",
        "σ": "Assumed standard deviation of a measurement",
    }
    title, tips = "Correspondences by part, lengths in mm", tuple(columns.values())
    return Table(title, tuple(columns), tuple(rows), tuple(limbs), tips=tips)


def _rows_table(rows: tuple[Rows, ...]) -> Table:
    found = []
    for row in rows:
        unit, factor = _UNITS[row.unit]
        rms = factor * float(np.sqrt(np.mean(row.residual**2)))
        strongest = float(np.abs(row.residual / row.sigma).max())
        name = _KINDS.get(row.kind, row.kind)
        found.append((name, str(len(row.part)), f"{rms:.1f} {unit}", f"{strongest:.1f} σ"))
    return Table("Other terms of the correction", ("Term", "Count", "RMS", "Largest"), tuple(found))


def _sigma(trace: StepTrace, step: Step, correction: Correction) -> StepContent:
    points, states = correction.sigma_points, states_of(trace.state_names)
    count = len(points.deviations)
    largest = np.abs(points.deviations).max(axis=0)
    rows = tuple(
        (state.label, *(f"{value * state.factor:.2f} {state.unit}" for value in values))
        for state, *values in zip(states, correction.before.sigma, largest, strict=True)
    )
    limbs = tuple(state.limb for state in states)
    tips = ("", "Standard deviation", "Largest distance of these poses from the estimate")
    table = Table("Spread", ("State", "σ", "Farthest"), rows, limbs, tips=tips)
    return _content(step, trace, f"{count} poses.", tables=(table,))


def _correct(trace: StepTrace, step: Step, correction: Correction) -> StepContent:
    before, after, names = correction.prior, correction.after, trace.state_names
    tables = [
        _moved_table(trace, correction.before.pose, correction.after.pose),
        deviations_table(before, after, names, ("Before", "After")),
    ]
    if trace.method != "thesis":
        tables.insert(1, _pull_table(correction))
    return _content(step, trace, tables=tuple(tables))


def _moved_table(trace: StepTrace, origin: Pose, to: Pose) -> Table:
    now = movement(trace.body, origin, to)
    since = movement(trace.body, trace.predicted.pose, to)
    rows = [
        ("torso, position", f"{1e3 * now.shift:.1f} mm", f"{1e3 * since.shift:.1f} mm"),
        ("torso, rotation", _degrees(now.turn), _degrees(since.turn)),
    ]
    for limb, a, b in zip(LIMBS[1:], now.limbs[1:], since.limbs[1:], strict=True):
        rows.append((limb_words(limb), _degrees(a), _degrees(b)))
    headings, tips = ("Limb", "This stage", "Total"), ("", "In this stage", "Since the prediction")
    return Table("Correction", headings, tuple(rows), ("torso", *LIMBS), tips=tips)


def _degrees(radians: float) -> str:
    return f"{np.degrees(radians):.2f} °"


def _pull_table(correction: Correction) -> Table:
    """What pulled where, in the state's own numbers."""
    points, from_prior = correction.points, ("prior (prediction)", correction.from_prior)
    sources: list[tuple[str, FloatArray]] = [from_prior]
    if len(points.residual):
        sources.insert(0, ("measured points", correction.gain @ points.residual))
    sources += [(_KINDS.get(row.kind, row.kind).lower(), row.dx) for row in correction.rows]
    turns = (slice(3, 6), *(slice(6 + 2 * k, 8 + 2 * k) for k in range(4)))
    rows = []
    for name, dx in sources:
        turned = (_degrees(float(np.linalg.norm(dx[turn]))) for turn in turns)
        rows.append((name, f"{1e3 * np.linalg.norm(dx[:3]):.1f} mm", *turned))
    headings = ("Contribution", "Position", "Rotation", "L upper", "L fore", "R upper", "R fore")
    return Table("Contribution", headings, tuple(rows))


def _collisions(trace: StepTrace, step: Step) -> StepContent:
    jump = trace.jump
    if jump is None:
        return _content(step, trace)
    said, least = [], 1e3 * jump.least_distance
    for side, arm in zip(("Left", "Right"), jump.arms, strict=True):
        why = [
            f"the {name} was {1000.0 * missing:.0f} mm too close to the torso (minimum "
            f"{least:.0f} mm)"
            for name, missing in (("elbow", arm.elbow_missing), ("hand", arm.hand_missing))
            if missing > 0.0
        ]
        if arm.bend_missing > 0.0:
            why.append(f"the elbow was bent {np.degrees(arm.bend_missing):.0f}° too far")
        found = " and ".join(why) if why else "no limit was violated"
        said.append(f"{side} arm: {found}.")
    table = _moved_table(trace, jump.before, jump.after)
    return _content(step, trace, " ".join(said), tables=(table,))


def _search(trace: StepTrace, step: Step) -> StepContent:
    search = trace.search
    if search is None:
        return _content(step, trace)
    reason = reason_of(search)
    words, parameters = _search_words(search), () if reason is None else reason.parameters
    if reason is not None:
        words = f"{words}\n{reason.words} {_LIMITS}"
    table = _arms_table(search)
    return _content(step, trace, words, tables=(table,), parameters=parameters)


def _search_words(search: Search) -> str:
    tried = [len(one.cost) for one in search.proposals]
    places = " and ".join(str(count) for count in tried) or "no"
    best = min(search.pairs, key=lambda pair: pair.cost, default=None)
    said = f"{places} candidates for the left and the right arm were scored."
    if search.followed.chosen or best is None:
        return f"{said} The tracked arms were kept."
    less = search.followed.cost - best.cost
    return f"{said} Other arms were chosen, at a cost lower by {less:.1f}."


def _arms_table(search: Search) -> Table:
    """Pairs of arm poses that were refined, with the terms of their cost."""
    pairs: list[tuple[str, Pair]] = [("followed", search.followed)]
    if search.truth is not None:
        pairs += [("reference", search.truth.given), ("reference, refined", search.truth.refined)]
    pairs += [(f"pair {i}", pair) for i, pair in enumerate(search.pairs, start=1)]
    names = [name for name in search.followed.terms if any(p.terms[name] for _, p in pairs)]
    known = [_COSTS.get(name, (name, "")) for name in names]
    headings = ("Arms", "Total", *(word for word, _ in known))
    tips = ("", "Sum of all terms", *(tip for _, tip in known))
    rows = tuple(
        (
            f"{name}, chosen" if pair.chosen else name,
            f"{pair.cost:.1f}",
            *(f"{pair.terms[each]:.1f}" for each in names),
        )
        for name, pair in pairs
    )
    title = f"Cost of pairs of arms. A new pair must cost {search.gain:g} less."
    title += "" if "keypoints" in names else " No keypoints take part."
    strong = tuple(i for i, (_, pair) in enumerate(pairs) if pair.chosen)
    return Table(title, headings, rows, strong=strong, tips=tips)


def _result(trace: StepTrace, step: Step, compared: str) -> StepContent:
    estimate = trace.estimate
    spent = tuple((_capital(name), f"{1e3 * value:.1f}") for name, value in trace.seconds.items())
    timing = Table("Time", ("Step", "Milliseconds"), spent)
    if not estimate.tracked:
        words = f"The frame was not tracked: {estimate.reason}."
        return _content(step, trace, words, tables=(timing,))
    moved = _moved_table(trace, trace.predicted.pose, trace.after.pose)
    short = Table(moved.title, moved.headings[:2], tuple(r[:2] for r in moved.rows), moved.limbs)
    deviations = deviations_table(
        trace.predicted, trace.after, trace.state_names, ("Predicted", "After")
    )
    return _content(step, trace, compared, tables=(short, timing, deviations))


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


_GREEK = {"alpha": "α", "beta": "β", "gamma": "γ"}
_TURNS = {"rx": "turn x", "ry": "turn y", "rz": "turn z", "tx": "turn x", "ty": "turn y"}


@dataclass(frozen=True)
class State:
    """One number of the state."""

    label: str
    limb: str
    unit: str
    factor: float


def states_of(names: tuple[str, ...]) -> tuple[State, ...]:
    """Labels and units of states by their names; the first three are positions."""
    found = []
    for index, name in enumerate(names):
        limb, _, axis = name.rpartition("_")
        said = _GREEK.get(axis, _TURNS.get(axis, axis))
        label = f"{limb_words(limb)} {said}"
        unit, factor = ("mm", 1e3) if index < 3 else ("°", float(np.degrees(1.0)))
        found.append(State(label, limb if limb in LIMBS else "", unit, factor))
    return tuple(found)


def part_words(part: int) -> str:
    """Name of a part as a person reads it."""
    return limb_words(PARTS[part]) if part >= 0 else "none"


def correlations_table(correction: Correction, names: tuple[str, ...]) -> Table:
    """For each state and part the strongest correlation with a pair of that part."""
    spread = np.outer(correction.before.sigma, np.sqrt(np.maximum(correction.P_zz, 0.0)))
    known = spread > 0.0
    correlation = np.where(known, correction.P_xz / np.where(known, spread, 1.0), 0.0)
    part, states = correction.points.part, states_of(names)
    parts = np.unique(part).tolist()
    strongest = [
        [row[part == one][np.abs(row[part == one]).argmax()] for one in parts]
        for row in correlation
    ]
    rows = tuple(
        (state.label, *(f"{value:+z.2f}" for value in values))
        for state, values in zip(states, strongest, strict=True)
    )
    title = "Strongest correlation of a state with a pair of each part"
    limbs = tuple(state.limb for state in states)
    words = [part_words(one) for one in parts]
    brief = (one.replace("left ", "L ").replace("right ", "R ") for one in words)
    tips = ("", *(f"Pairs of the {one}" for one in words))
    return Table(title, ("State", *brief), rows, limbs, tips=tips)


def deviations_table(
    before: Belief, after: Belief, names: tuple[str, ...], headings: tuple[str, str]
) -> Table:
    """Standard deviations of all states before and after."""
    states, rows = states_of(names), []
    for state, a, b in zip(states, before.sigma, after.sigma, strict=True):
        change = f"{100.0 * (b / a - 1.0):+z.0f} %" if a > 0.0 else ""
        values = (f"{value * state.factor:.2f} {state.unit}" for value in (a, b))
        rows.append((state.label, *values, change))
    limbs = tuple(state.limb for state in states)
    return Table("Standard deviations", ("State", *headings, "Change"), tuple(rows), limbs)
