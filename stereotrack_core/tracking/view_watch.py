"""Views whose measurements contradict those of the others, and are left out until they agree.

A camera that was knocked, runs late, or sees a shadow or a passer-by as part of the person pulls
the body away. Two signs tell which view it is: how far its silhouette lies from the body's outline,
and how many of its points the body leaves unexplained; both beside the others' median.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.residuals.silhouette import contours_of, edge_maps
from stereotrack_core.tracking.residuals.surface import surface_distances, unexplained_fraction

_LEFT_OUT = "contradicts the others and is not used"
_EVERY = 3  # frames between two judgements: a view that goes wrong stays wrong for longer
_POINTS_EVERY = 5  # step through the points that are judged
_NEW = 0.3  # weight of the latest frame in the averages over time
_FIRST = 5  # judged frames before any view is left out: the first pose may be what is wrong
_FEWEST_VIEWS = 3  # of two that contradict each other, neither is known to be right
_FEWEST = 8  # contours or points without which a view is not judged
# Ratios to the median of the other views from which a view is left out, and used again. Undisturbed
# views differ by up to 1.35 (contours) and 1.5 (points).
_WORSE, _AGREES = 1.6, 1.25
# Deviation of contours, metres, and unexplained fraction that a view needs as well. Undisturbed:
# 0.015 to 0.022 m and 0.15 to 0.34; a camera turned by 1.4 degrees: 0.03 to 0.06 m; by 3.5 degrees:
# 0.1 m and 0.5.
_LEAST = np.array([0.028, 0.42])
_UNJUDGED = np.full(2, np.nan)


@dataclass(frozen=True, eq=False)
class ViewWatch:
    """Signs of the views so far, V views."""

    names: tuple[str, ...] = ()
    # (V, 2). Averages over time of the robust standard deviation of contours, metres, and the
    # unexplained fraction of points; NaN where never judged.
    signs: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    judged: int = 0  # frames so far
    left_out: str = ""  # the view that is not used; empty if all are

    def trusted(self, cloud: Cloud) -> Cloud:
        """The cloud without what the view measures that is left out."""
        if self.left_out not in cloud.view_names:
            return cloud
        kept = cloud.part(cloud.view != cloud.view_names.index(self.left_out))
        depths = {name: d for name, d in cloud.depths.items() if name != self.left_out}
        return replace(kept, depths=depths)

    def updated(self, cloud: Cloud, body: BodyModel, pose: Pose) -> ViewWatch:
        """The watch after a frame with all that its views measure, and the pose it was given."""
        if cloud.frame % _EVERY or len(cloud.view_names) < _FEWEST_VIEWS:
            return self
        now = np.array([_signs(cloud, name, body, pose) for name in cloud.view_names])
        judged_before = dict(zip(self.names, self.signs, strict=True))
        before = np.array([judged_before.get(name, _UNJUDGED) for name in cloud.view_names])
        known = np.where(np.isnan(now), before, now)
        signs = np.where(np.isnan(before), known, before + _NEW * (known - before))
        judged = self.judged + 1
        left_out = self._left_out(cloud.view_names, signs) if judged > _FIRST else ""
        return ViewWatch(cloud.view_names, signs, judged, left_out)

    def _left_out(self, names: tuple[str, ...], signs: FloatArray) -> str:
        others = [_median(np.delete(signs, k, axis=0)) for k in range(len(signs))]
        with np.errstate(invalid="ignore", divide="ignore"):
            ratios: FloatArray = signs / np.array(others)
        # Passers-by leave points unexplained and the person's contours where they are: without
        # such a view 12 % of the arms were lost, with it none.
        ratios[np.isfinite(ratios[:, 0]), 1] = 0.0
        if self.left_out in names:
            ratio = ratios[names.index(self.left_out)]
            if np.nanmax(ratio, initial=0.0) > _AGREES:
                return self.left_out
        wrong = np.nan_to_num(np.where(signs > _LEAST, ratios, 0.0)).max(axis=1)
        worst = int(np.argmax(wrong))
        return names[worst] if wrong[worst] > _WORSE else ""

    @property
    def doubts(self) -> Mapping[str, str]:
        """By view name, a sentence on why it is not used."""
        if not self.left_out:
            return {}
        k = self.names.index(self.left_out)
        (own, share), others = self.signs[k], np.nanmedian(np.delete(self.signs, k, 0), axis=0)
        return {
            self.left_out: (
                f"View {self.left_out} {_LEFT_OUT}: its contours lie "
                f"{1000 * own:.0f} mm beside the body ({1000 * others[0]:.0f} mm in the others), "
                f"and {100 * share:.0f} % of its points are not explained "
                f"({100 * others[1]:.0f} %); its camera may have moved or be late."
            )
        }


def views_left_out(problems: Mapping[str, str]) -> tuple[str, ...]:
    """Views that were left out, of what the views of a frame lack (``Cloud.problems``)."""
    return tuple(view for view, sentence in problems.items() if _LEFT_OUT in sentence)


def _median(signs: FloatArray) -> FloatArray:
    """Medians (K,) of signs (V, K); NaN where fewer than two are known."""
    known = np.sum(np.isfinite(signs), axis=0) >= _FEWEST_VIEWS - 1
    result = np.full(signs.shape[1], np.nan)
    result[known] = np.nanmedian(signs[:, known], axis=0)
    return result


def _signs(cloud: Cloud, name: str, body: BodyModel, pose: Pose) -> tuple[float, float]:
    """Deviation of one view's contours, metres, and unexplained fraction of its points."""
    deviation = share = float("nan")
    edges = edge_maps(replace(cloud, depths={n: d for n, d in cloud.depths.items() if n == name}))
    distance = contours_of(edges, body, body.frames(pose)).distance
    if len(distance) >= _FEWEST:
        deviation = 1.4826 * float(np.median(np.abs(distance)))
    points = cloud.points[cloud.view == cloud.view_names.index(name)][::_POINTS_EVERY]
    if len(points) >= _FEWEST:
        share = unexplained_fraction(surface_distances(points, body, pose))
    return deviation, share
