"""Contours against the same measurement in plain NumPy, one place of one cone at a time."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from stereotrack_core.body.manifold import OUTLINE
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.cloud import EdgeMap
from stereotrack_core.tracking.residuals.silhouette import (
    SilhouetteObservation,
    contours_of,
    silhouettes_of,
)
from tests.tracking.scenes import POSES, cloud_of
from tests.tracking.views import cloud_seen, looking

BODY, FOCAL, CENTRE = body_model(AVERAGE), 310.0, np.array([158.0, 121.0])
LEGS, LIMBS = (6, 7, 8, 9), (2, 3, 4, 5)
SIZE = 48
"""Side of an edge map, pixels: so small that many contours are near its border."""


def _edges(eye, rng, layers=3, span=((40, 200), (60, 270))):
    """Maps, side by side, of waves that are no silhouette, with ranges around the body's."""
    place = looking(eye).inverse().matrix()[:3]
    near = np.linalg.norm(np.subtract(eye, POSES["t"].position))
    rows, columns = np.mgrid[:SIZE, :SIZE]
    (top, bottom), (left, right) = span
    corners = np.mgrid[:layers, top:bottom:SIZE, left:right:SIZE].reshape(3, -1).T[:, 1:]
    found = []
    for top, left in corners + rng.integers(-20, 20, corners.shape):
        turn, height = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(1.0, 16.0)
        along = (columns * np.cos(turn) + rows * np.sin(turn)) / 7.0
        distance = height * np.sin(along) + rng.uniform(-6.0, 6.0)
        ranges = near + rng.uniform(-0.25, 0.25, (SIZE, SIZE))
        pinhole = np.array([FOCAL, *CENTRE, left, top])
        maps = distance.astype(np.float32), ranges.astype(np.float32)
        found.append(EdgeMap(*maps, pinhole, place))
    return tuple(found)


class _View:
    """The cones as one view sees them, and the places where it grazes them."""

    def __init__(self, placed, place):
        self.placed, self.turn, self.shift = placed, place[:, :3], place[:, 3]
        self.ends = [self._image(cone) for cone in placed]
        self.in_front = [k for k, (ends, _) in enumerate(self.ends) if np.isfinite(ends).all()]
        self.places = [
            place
            for c in self.in_front
            if placed[c]["part"] not in LEGS
            for share in (0.1, 0.3, 0.5, 0.7, 0.9)
            for place in self._contours(c, share)
        ]

    def seen(self, points):
        """Pixels (N, 2) and ranges (N,) of points (N, 3), world."""
        local = points @ self.turn.T + self.shift
        return CENTRE + FOCAL * local[:, :2] / np.maximum(local[:, 2:], 1e-6), local[:, 2]

    def grazed(self, cone, share):
        """Both places (2, 3), cone's frame, at which sight lines touch a cone."""
        away = (-self.turn.T @ self.shift - cone["origin"]) @ cone["rotation"]
        x, y = away[0], away[1] / cone["flatness"]
        radius = (1.0 - share) * cone["r1"] + share * cone["r2"]
        aside = radius / np.hypot(x, y) * np.array([-y, cone["flatness"] * x])
        return np.array([[*side, share * cone["height"]] for side in (aside, -aside)])

    def _image(self, cone):
        """Middles (2, 2) and radii (2,) of both ends, pixels; NaN if one is too near."""
        both = [self.grazed(cone, s) @ cone["rotation"].T + cone["origin"] for s in (0.0, 1.0)]
        pixels, depth = map(np.array, zip(*map(self.seen, both), strict=True))
        radii = 0.5 * np.linalg.norm(pixels[:, 0] - pixels[:, 1], axis=1)
        return np.where(depth.min() < 0.2, np.nan, pixels.mean(axis=1)), radii

    def from_image(self, c, pixel):
        """Pixels from a cone's image, negative inside, and where along it: 0 to 1 beside it."""
        (a, b), (ra, rb) = self.ends[c]
        free = (pixel - a) @ (b - a) / ((b - a) @ (b - a))
        t = np.clip(free, 0.0, 1.0)
        return np.linalg.norm(pixel - a - t * (b - a)) - (ra + t * (rb - ra)), free

    def _contours(self, c, share):
        """Cone, place in it and in the world, pixel, range, and outward direction in the image."""
        cone, (a, b) = self.placed[c], self.ends[c][0]
        for place in self.grazed(cone, share):
            point = cone["rotation"] @ place + cone["origin"]
            [pixel], [depth] = self.seen(point[None])
            out = pixel - (a + share * (b - a))
            if np.linalg.norm(out) >= 0.5:
                out /= np.linalg.norm(out)
                beside = pixel + 0.04 * FOCAL / depth * out
                if all(self.from_image(k, beside)[0] >= 0.0 for k in self.in_front if k != c):
                    yield c, place, point, pixel, depth, out

    def is_shared(self, pixel):
        """Whether trunk, head or legs end at a pixel as well."""
        found = [
            self.from_image(k, pixel) for k in self.in_front if self.placed[k]["part"] not in LIMBS
        ]
        return any(0.0 <= along <= 1.0 and abs(off) < 2.5 for off, along in found)

    def measured(self, edge):
        """Cone, distance, place and direction of what is near an edge."""
        for c, place, point, pixel, depth, out in self.places:
            inner = pixel - edge.pinhole[3:]
            if not ((inner >= 2.0) & (inner <= SIZE - 4.0)).all():
                continue
            around = inner[:, None] + 1.5 * np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
            value, *beside = map_coordinates(edge.distance.astype(float), around[::-1], order=1)
            slope = np.array([beside[0] - beside[1], beside[2] - beside[3]])
            if np.linalg.norm(slope) < 1.0:
                continue
            normal = slope / np.linalg.norm(slope)
            column, row = np.rint(inner - (value + 3.0) * normal).astype(int)
            inside = 0 <= column < SIZE and 0 <= row < SIZE
            if not inside or abs(edge.range_z[row, column] - depth) > 0.15 or normal @ out <= 0.3:
                continue
            if self.placed[c]["part"] in LIMBS and self.is_shared(pixel - value * normal):
                continue
            # The line of sight is square to the direction, which is that of the edge in the image.
            direction = np.append(normal, -normal @ (pixel - CENTRE) / FOCAL)
            scale, squares = np.linalg.norm(direction), place[:2] ** 2
            margin = self.placed[c]["outline"] @ squares / squares.sum()
            away = -value * depth / FOCAL / scale - margin
            if abs(away) < 0.15:
                yield c, away, point, self.turn.T @ direction / scale


@pytest.mark.parametrize(("pose", "eye"), [("reaching", (0.6, 2.6, 1.5)), ("t", (0.2, 0.5, 1.3))])
def test_contours_are_measured_as_plain_numpy_does(pose, eye, rng):
    span = ((-40, 300), (-40, 340)) if eye[1] < 1.0 else ((40, 200), (60, 270))
    edges, frames = _edges(eye, rng, 5, span), BODY.frames(POSES[pose])
    view = _View(placed_cones(BODY, frames), edges[0].camera_from_world)
    expected = [one for edge in edges for one in view.measured(edge)]
    assert len(expected) > 5
    found = contours_of(edges, BODY, frames)
    cone, distance, point, direction = map(np.array, zip(*expected, strict=True))
    np.testing.assert_array_equal(found.cone, cone)
    np.testing.assert_allclose(found.distance, distance, atol=1e-9)
    np.testing.assert_allclose(found.point, point, atol=1e-9)
    np.testing.assert_allclose(found.direction, direction, atol=1e-9)


def test_contours_weigh_by_their_distance_and_share_what_a_view_can_tell(rng):
    edges, pose = _edges((0.6, 2.6, 1.5), rng), POSES["t"]
    seen = contours_of(edges, BODY, BODY.frames(pose))
    [found] = SilhouetteObservation(edges, 0.02, 3.0).residuals(BODY, pose)
    parts = BODY.cones["part"][seen.cone]
    order = np.argsort(parts, kind="stable")
    weight = (0.06**2 / (0.06**2 + seen.distance**2)) ** 2
    expected = {
        "part": parts,
        "distance": seen.distance,
        "data": seen.point + seen.distance[:, None] * seen.direction,
        "weight": weight,
        "variance": 0.02**2 * len(parts) / 3.0 / weight,
    }
    assert found.kind == OUTLINE
    for name, values in expected.items():
        np.testing.assert_allclose(getattr(found, name), values[order], err_msg=name)


def test_views_without_ranges_confuse_parts_and_count_for_less():
    stereo, mono = cloud_seen([], "N"), cloud_seen([], "")
    assert [silhouettes_of(one, 0.1).effective for one in (stereo, mono)] == [120.0, 24.0]
    assert silhouettes_of(cloud_of(np.zeros((0, 3))), 0.1).edges == ()
