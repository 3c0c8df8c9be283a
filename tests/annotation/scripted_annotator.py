"""An annotator by script: sees every landmark in every image, and corrects what is too far off.

It knows where it sees the landmarks; what proposes knows only its clicks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stereotrack_core.annotation.click import ACCEPTED, Click, ClickKey, Prediction
from stereotrack_core.annotation.follow import follow_clicks
from stereotrack_core.annotation.follow_body import BodyStep, FollowedBody, follow_body, told_by
from stereotrack_core.annotation.landmark_filter import ProposalQuestion
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.propose import Proposer
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.reader import FrameReader

FAR_OFF = 3.0
"""Pixels; what is farther off than that is clicked."""


@dataclass
class Annotation:
    """What came of it."""

    clicks: list[Click] = field(default_factory=list)
    clicked: list[int] = field(default_factory=list)
    """For every frame: how many clicks it took."""
    keys: list[int] = field(default_factory=list)
    """For every frame: how often a view was accepted."""
    right_away: list[float] = field(default_factory=list)
    """For every frame: share of the proposals that were right before the first click."""


def seen_by(
    pixels: Mapping[ClickKey, np.ndarray], *, sigma: float, seed: int
) -> dict[ClickKey, tuple[float, float]]:
    """Where somebody sees landmarks that are at these pixels, to `sigma` pixels per axis."""
    rng = np.random.default_rng(seed)
    noisy = {key: place + rng.normal(0.0, sigma, 2) for key, place in pixels.items()}
    return {key: (float(x), float(y)) for key, (x, y) in noisy.items()}


def annotate(
    seen: Mapping[ClickKey, tuple[float, float]],
    cameras: Mapping[str, Camera],
    fps: float,
    *,
    reader: FrameReader | None = None,
    off_px: Callable[[str], float] = lambda _camera: FAR_OFF,
    motion: Mapping[int, np.ndarray] | None = None,
    proportions: Proportions | None = None,
    asks: bool = False,
) -> Annotation:
    """Annotate all frames that something is seen in, view by view.

    In every view the proposal that is farthest off is clicked until none is too far off, then the
    rest of the view is accepted with one key. Without a reader nothing is followed, and without
    proportions not the body.
    """
    done, proposer, motion = Annotation(), Proposer(), motion or {}
    frames = sorted({key.frame for key in seen})
    steps: list[BodyStep] = []
    for place, frame in enumerate(frames):
        wanted = {key: at for key, at in seen.items() if key.frame == frame}
        around = tuple(
            one for one in done.clicks if one.frame in frames[max(place - 10, 0) : place]
        )
        last = [one for one in around if one.frame == frames[place - 1]]

        followed: tuple[Prediction, ...] = ()
        if reader is not None and last:
            if proportions is not None:
                body = FollowedBody(cameras, proportions)
                step = follow_body(reader, around, frames[place - 1], frame, body)
                steps = [*steps[-10:], *((step,) if step is not None else ())]
            told = told_by(steps, frame)
            open_ones = [one for one in last if one.landmark not in told]
            followed = follow_clicks(reader, open_ones, (frame,))

        def proposed(own: Sequence[Click], now=(frame, around, followed, tuple(steps))):
            frame, around, followed, seen = now
            question = ProposalQuestion(
                frame,
                tuple(own),
                around,
                followed,
                cameras,
                NINE.names,
                fps,
                {},
                motion,
                seen,
                asks,
            )
            return {one.key: one for one in proposer(question).predictions}

        _annotate_frame(done, wanted, cameras, proposed, off_px)
    return done


def _annotate_frame(
    done: Annotation,
    wanted: Mapping[ClickKey, tuple[float, float]],
    cameras: Mapping[str, Camera],
    proposed: Callable[[Sequence[Click]], dict[ClickKey, Prediction]],
    off_px: Callable[[str], float],
) -> None:
    own: dict[ClickKey, Click] = {}
    proposals = proposed(())

    def off(key: ClickKey) -> float:
        if key not in proposals:
            return np.inf
        away = np.subtract(proposals[key].position, wanted[key])
        return float(np.hypot(*away)) / off_px(key.camera)

    done.right_away.append(float(np.mean([off(key) <= 1.0 for key in wanted])))
    clicks = keys = 0
    for camera in cameras:
        here = [key for key in wanted if key.camera == camera]
        while wrong := [key for key in here if key not in own and off(key) > 1.0]:
            worst = max(wrong, key=off)
            own[worst] = Click(*worst, wanted[worst])
            clicks += 1
            proposals = proposed(tuple(own.values()))
        rest = [key for key in here if key not in own]
        own |= {key: Click(*key, proposals[key].position, origin=ACCEPTED) for key in rest}
        keys += bool(rest)
    done.clicks += own.values()
    done.clicked.append(clicks)
    done.keys.append(keys)
