"""One ``[[views]]`` section of ``recording.toml``."""

from __future__ import annotations

from typing import cast

from stereotrack_core.recording.description import Stream, View, ViewKind
from stereotrack_core.recording.toml_table import Table

STREAM_KEYS: dict[str, tuple[str, ...]] = {
    "stereo": ("right", "left"),
    "depth": ("image", "depth"),
    "mono": ("image",),
}
"""Streams that a view of each kind must have, the reference image first."""

EXAMPLE = 'camera = "...", frames = "..."'

LARGEST_UNIT_M = 1.0


def parse_view(table: Table) -> View | None:
    """The view, or None where something essential is missing (with complaints)."""
    name = table.text("name", required=True)
    kind = table.text("kind", required=True)
    if kind is not None and kind not in STREAM_KEYS:
        table.complain(
            "kind", f"the kind {kind!r} is not known", 'Write "stereo", "depth" or "mono".'
        )
        return None
    if name is None or kind is None:
        return None
    streams = [_stream(table, key) for key in STREAM_KEYS[kind]]
    mask = _stream(table, "mask", required=False) if kind == "depth" else None
    image = streams[0]
    second = streams[1] if len(streams) > 1 else None
    if image is None or (len(streams) > 1 and second is None):
        return None
    return View(
        name=name,
        kind=cast(ViewKind, kind),
        image=image,
        left=second if kind == "stereo" else None,
        depth=second if kind == "depth" else None,
        depth_unit=_depth_unit(table) if kind == "depth" else 0.001,
        mask=mask,
        display_rotation=_display_rotation(table),
    )


def _stream(view: Table, key: str, *, required: bool = True) -> Stream | None:
    table = view.table(key, required=required, example=EXAMPLE)
    if table is None:
        return None
    camera = table.text("camera", required=key != "mask")
    frames = table.text("frames", required=True)
    first_frame = table.whole_number("first_frame", 0)
    if first_frame < 0:
        table.complain("first_frame", f"{first_frame} is before the stream", "Write 0 or more.")
        first_frame = 0
    time_offset = table.number("time_offset", 0.0)
    if frames is None or (camera is None and key != "mask"):
        return None
    return Stream(
        camera=camera or "",
        frames=frames,
        background=table.text("background"),
        first_frame=first_frame,
        time_offset=time_offset or 0.0,
    )


def _depth_unit(view: Table) -> float:
    table = view.table("depth")
    unit = 0.001 if table is None else table.number("unit", 0.001)
    if unit is not None and not 0 < unit <= LARGEST_UNIT_M:
        view.complain("depth.unit", f"{unit:g} metres per count is impossible", "Write e.g. 0.001.")
    return unit if unit is not None and 0 < unit <= LARGEST_UNIT_M else 0.001


def _display_rotation(table: Table) -> int:
    rotation = table.whole_number("display_rotation", 0)
    if rotation not in (0, 90, 180, 270):
        table.complain(
            "display_rotation",
            f"{rotation} degrees is not possible",
            "Write 0, 90, 180 or 270 (clockwise).",
        )
        return 0
    return rotation
