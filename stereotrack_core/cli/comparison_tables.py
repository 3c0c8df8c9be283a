"""Tables of runs beside each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.error_tables import error_facts, measure_rows
from stereotrack_core.cli.output import Table, number

if TYPE_CHECKING:
    from stereotrack_core.evaluation.comparison.compare import Comparison, Pair
    from stereotrack_core.evaluation.comparison.paired import Paired


def comparison_table(comparison: Comparison, pair: Pair, title: str = "") -> Table:
    """Means of both runs, their difference with its interval, and what that comes to."""
    from stereotrack_core.evaluation.comparison.compare import verdict

    first, second = pair.first, pair.second
    frames = len(comparison.frames)
    where = f"{title}: " if title else ""
    heading = f"{where}{second} beside {first}, means over {frames} frames"
    rows = [
        (
            f"{measure.label} [{measure.unit}]",
            number(measure.paired.first, 2),
            number(measure.paired.second, 2),
            _signed(measure.paired.difference),
            _interval(measure.paired),
            _percent(measure.paired.better),
            number(measure.paired.p, 3),
            str(measure.paired.block),
            verdict(measure, first, second),
        )
        for measure in pair.measures
    ]
    columns = (
        *("measure", f">{first}", f">{second}", f">{second} - {first}", ">95 % interval"),
        *(f">{second} better in", ">p", ">block", "what these frames show"),
    )
    return Table(heading, columns, rows)


def apart_table(pair: Pair, title: str = "") -> Table:
    """How far two runs are from each other."""
    where = f"{title}: " if title else ""
    rows = measure_rows(pair.apart)
    rows.append(("arm segments over 45 deg apart [%]", number(100.0 * pair.apart.lost), "", ""))
    heading = f"{where}{pair.second} from {pair.first}, how far apart they are"
    return Table(heading, ("measure", ">mean", ">median", ">95 %"), rows)


def comparison_facts(comparison: Comparison) -> dict[str, Any]:
    """The same for JSON."""
    return {
        "frames": len(comparison.frames),
        "first_frame": comparison.frames[0],
        "last_frame": comparison.frames[-1],
        "against_reference": comparison.against_reference,
        "pairs": [_pair_facts(pair) for pair in comparison.pairs],
    }


def _pair_facts(pair: Pair) -> dict[str, Any]:
    from stereotrack_core.evaluation.comparison.compare import verdict

    return {
        "first": pair.first,
        "second": pair.second,
        "measures": {
            measure.name: {
                "unit": measure.unit,
                "first_mean": measure.paired.first,
                "second_mean": measure.paired.second,
                "difference": measure.paired.difference,
                "low": measure.paired.low,
                "high": measure.paired.high,
                "better_percent": 100.0 * measure.paired.better,
                "worse_percent": 100.0 * measure.paired.worse,
                "p": measure.paired.p,
                "frames": measure.paired.frames,
                "block_frames": measure.paired.block,
                "independent_frames": measure.paired.independent,
                "differs": measure.paired.differs,
                "verdict": verdict(measure, pair.first, pair.second),
            }
            for measure in pair.measures
        },
        "apart": error_facts(pair.apart),
    }


def _signed(value: float) -> str:
    return f"{value:+.2f}" if math.isfinite(value) else "-"


def _interval(found: Paired) -> str:
    return f"{found.low:+.2f} to {found.high:+.2f}" if found.enough else "-"


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if math.isfinite(share) else "-"
