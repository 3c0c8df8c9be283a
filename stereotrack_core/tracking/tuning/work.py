"""What has to be done anew after a change, in words."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.stages import Stage, changed_names, stage_of


@dataclass(frozen=True)
class Work:
    """What an attempt does.

    Attributes
    ----------
    frames : int
        Frames of the stretch.
    matched, measured, fused : int
        How many of them are matched, made into points, and freed of outliers.
    background : bool
        Whether the background is learned.
    shape : bool
        Whether the body's shape is fitted.
    tracked : bool
        False where nothing at all is to be done.
    """

    frames: int
    matched: int = 0
    measured: int = 0
    fused: int = 0
    background: bool = False
    shape: bool = False
    tracked: bool = True

    @property
    def words(self) -> str:
        """``matching and points of 20 frames, the background, and tracking``."""
        if not self.tracked:
            return "nothing"
        parts = []
        if self.matched:
            parts.append(f"matching and points of {_frames(self.measured)}")
        elif self.measured:
            parts.append(f"points of {_frames(self.measured)}")
        elif self.fused:
            parts.append(f"outliers of {_frames(self.fused)}")
        if self.background:
            parts.append("the background")
        if self.shape:
            parts.append("the body's shape")
        return _listed([*parts, "tracking"]) if parts else "tracking only"


def what_is_recomputed(old: Settings, new: Settings, frames: int) -> str:
    """What a stretch of so many frames needs when settings change, if all before was kept.

    Returns
    -------
    str
        ``tracking only``, ``points of 20 frames, the body's shape and tracking``, ``nothing``.
    """
    return work_after(old, new, frames).words


def work_after(old: Settings, new: Settings, frames: int) -> Work:
    """The same as :func:`what_is_recomputed` in numbers."""
    stages = {stage_of(name) for name in changed_names(old, new)}
    first = min(stages, default=None)
    if first is None:
        return Work(frames, tracked=False)
    return Work(
        frames,
        matched=frames if first <= Stage.MATCHING else 0,
        measured=frames if first <= Stage.POINTS else 0,
        fused=frames if first <= Stage.FUSION else 0,
        background=first <= Stage.BACKGROUND,
        shape=first <= Stage.SHAPE and fits_shape(new),
    )


def fits_shape(settings: Settings) -> bool:
    """Whether the body's shape is fitted to the recording at all."""
    return settings.tracking.fit_shape and settings.tracking.matching == "data_to_model"


def _frames(count: int) -> str:
    return f"{count} frame{'' if count == 1 else 's'}"


def _listed(parts: list[str]) -> str:
    return f"{', '.join(parts[:-1])} and {parts[-1]}"
