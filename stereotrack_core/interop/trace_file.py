"""What happened inside a frame as files: the cross-covariance as CSV, all numbers as ``.npz``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.atomic import write_file
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.errors import InputError
from stereotrack_core.interop.npz import archive_bytes
from stereotrack_core.tables import csv_text
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.trace import REASONS, Correction, StepTrace

TRACE_SUFFIXES = (".csv", ".npz")

_OF_POINTS = ("part", "place", "foot", "direction", "residual", "sigma", "weight")
"""What files call the numbers of :class:`Correspondences`, in their order."""


def write_trace(path: Path, trace: StepTrace, correction: int) -> None:
    """Write all numbers of a trace (``.npz``) or a correction's cross-covariance (``.csv``).

    InputError for another suffix, for a table where there is no such correction, and where
    nothing can be written.
    """
    suffix = path.suffix.lower()
    if suffix == ".npz":
        write_file(path, archive_bytes(_trace_arrays(trace)))
    elif suffix == ".csv":
        if not 0 <= correction < len(trace.corrections):
            raise InputError(
                "this frame has no cross-covariance because no points were used for correction",
                where=f"frame {trace.frame}",
                remedy="Export as .npz, which holds all available numbers.",
            )
        names = trace.state_names
        write_file(path, _cross_covariance_csv(names, trace.corrections[correction]))
    else:
        raise InputError(
            "the step trace cannot be written to this type of file",
            where=str(path),
            remedy="Use a name that ends in .csv (cross-covariance) or .npz (all numbers).",
        )


def _cross_covariance_csv(names: tuple[str, ...], correction: Correction) -> str:
    """Cross-covariance as a table: a row for each point, a column for each state.

    Columns before them name the point: its part, its place and partner, its residual, the standard
    deviation that its measurement is taken to have, its weight, and the variance predicted for it.
    Metres and radians, so P_xz is in m2 for positions and rad m for angles.
    """
    points = correction.points
    places = [f"{end}_{axis}_m" for end in ("place", "foot") for axis in "xyz"]
    fixed = ["point", "part", *places, "residual_m", "sigma_m", "weight", "P_zz_m2"]
    rows = [
        [
            i,
            PARTS[points.part[i]],
            *points.data[i].tolist(),
            *points.model[i].tolist(),
            float(points.residual[i]),
            float(points.sigma[i]),
            float(points.weight[i]),
            float(correction.P_zz[i]),
            *correction.P_xz[:, i].tolist(),
        ]
        for i in range(len(points.part))
    ]
    return csv_text([*fixed, *(f"P_xz_{name}" for name in names)], rows)


def _trace_arrays(trace: StepTrace) -> dict[str, NDArray[np.generic]]:
    """All numbers of a trace by name; those of correction 2 begin with ``correction_2_``."""
    arrays: dict[str, NDArray[np.generic]] = {
        "frame": np.array(trace.frame),
        "method": np.array(trace.method),
        "state_names": np.array(trace.state_names),
        "part_names": np.array(PARTS),
        "reasons": np.array(REASONS),
        "notes": np.array(trace.notes, dtype=np.str_),
        "tracked": np.array(trace.estimate.tracked),
        "step_names": np.array(list(trace.seconds), dtype=np.str_),
        "step_seconds": np.array(list(trace.seconds.values()), dtype=np.float64),
        "corrections": np.array(len(trace.corrections)),
    }
    for name in ("before", "predicted", "after"):
        arrays |= _belief(name, getattr(trace, name))
    for i, correction in enumerate(trace.corrections, start=1):
        own = _correction_arrays(correction)
        arrays |= {f"correction_{i}_{name}": values for name, values in own.items()}
    if trace.search is not None:
        pairs = (trace.search.followed, *trace.search.pairs)
        arrays["search_terms"] = np.array(list(pairs[0].terms), dtype=np.str_)
        arrays["search_costs"] = np.array([list(pair.terms.values()) for pair in pairs])
        arrays["search_chosen"] = np.array([pair.chosen for pair in pairs])
    return arrays


def _correction_arrays(correction: Correction) -> Mapping[str, NDArray[np.generic]]:
    points, unused = correction.points, correction.unused
    return {
        "stage": np.array(correction.stage),
        "iteration": np.array(correction.iteration),
        **_belief("prior", correction.prior),
        **_belief("before", correction.before),
        **_belief("after", correction.after),
        "sigma_deviations": correction.sigma_points.deviations,
        **_pose("sigma", correction.sigma_points.poses),
        **dict(zip(_OF_POINTS, vars(points).values(), strict=True)),
        "unused_place": unused.place,
        "unused_why": unused.why,
        **{name: getattr(correction, name) for name in ("P_xz", "P_zz", "gain", "dx")},
        "dx_from_prior": correction.from_prior,
    } | {f"dx_{rows.kind}_{rows.unit}": rows.dx for rows in correction.rows}


def _pose(name: str, pose: Pose) -> dict[str, NDArray[np.generic]]:
    return {f"{name}_position": pose.position, f"{name}_rotations": pose.rotations}


def _belief(name: str, belief: Belief) -> dict[str, NDArray[np.generic]]:
    return _pose(name, belief.pose) | {f"{name}_P": belief.P}
