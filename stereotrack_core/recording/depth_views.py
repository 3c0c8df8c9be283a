"""Which views of a recording give depth."""

from __future__ import annotations

from collections.abc import Sequence

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording


def usable_views(recording: Recording, views: Sequence[str] | None) -> tuple[str, ...]:
    """Names of the views that give depth and were asked for, in the recording's order."""
    deep = tuple(view.name for view in recording.views if view.kind != "mono")
    if not deep:
        raise InputError(
            "no view provides depth, so there is nothing to track",
            where=str(recording.folder / "recording.toml"),
            remedy="Tracking needs a view of kind stereo or depth; mono views can be annotated.",
        )
    if views is None:
        return deep
    unknown = [name for name in views if name not in deep]
    if unknown or not views:
        raise InputError(
            f"unknown view with depth: {', '.join(unknown) or 'none given'}",
            where="--views",
            remedy=f"Available: {', '.join(deep)}.",
        )
    return tuple(name for name in deep if name in views)
