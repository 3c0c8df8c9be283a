"""MMPose's and RTMPose's predictions, as JSON of one video or camera.

The demo scripts write ``meta_info`` and ``instance_info``, whose ``frame_id`` begins at 1; the
inferencer writes a list of ``frame_id`` and ``instances`` that begins at 0. An instance has
``keypoints`` and ``keypoint_scores``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.people import FileRow, Who, stated_name
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import checked_frame
from stereotrack_core.plain_data import Kind, check_kind

_REMEDY = "Use the .json that MMPose writes with --save-predictions or pred_out_dir."
_FRAMES: Kind = [
    {
        "frame_id": int,
        "instances": [{"keypoints": [[float]], "keypoint_scores": [float]}],
    }
]
_KIND: Kind = {
    "meta_info": {"keypoint_id2name": {str: str}},
    "instance_info": _FRAMES,
}
_FIRST_OF_DEMO = 1


def is_mmpose(content: Any) -> bool:
    """Whether JSON is such a file."""
    if isinstance(content, Mapping):
        return "instance_info" in content
    first = content[0] if isinstance(content, list) and content else None
    return isinstance(first, Mapping) and {"frame_id", "instances"} <= set(first)


def read_mmpose(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of the file; InputError where it makes no sense, or its camera cannot be told."""
    where = str(source.path)
    camera, first = source.camera_of(source.path.name, where), 0
    named: Mapping[str, str] = {}
    if isinstance(content, Mapping):
        check_kind(content, _KIND, where, _REMEDY)
        first = _FIRST_OF_DEMO
        named = (content.get("meta_info") or {}).get("keypoint_id2name") or {}
        content = content.get("instance_info") or []
    check_kind(content, _FRAMES, where, _REMEDY)
    for one in content:
        if (number := one.get("frame_id")) is None:
            raise InputError("a frame has no frame_id", where=where, remedy=_REMEDY)
        frame = checked_frame(float(number - first), where=where)
        for index, instance in enumerate(one.get("instances") or []):
            who = Who(index, stated_name(instance.get("track_id", instance.get("instance_id"))))
            yield from _rows(instance, source, named, (frame, camera, who))


def _rows(
    instance: Mapping[str, Any],
    source: KeypointSource,
    named: Mapping[str, str],
    place: tuple[int, str, Who],
) -> Iterator[FileRow]:
    frame, camera, who = place
    points: Sequence[Sequence[float]] = instance.get("keypoints") or []
    sure = instance.get("keypoint_scores") or [1.0] * len(points)
    where = f"{source.path}, frame {frame}"
    if len(sure) != len(points) or any(len(point) < 2 for point in points):
        raise InputError(
            "keypoints and keypoint_scores do not belong together", where=where, remedy=_REMEDY
        )
    names = (
        [named.get(str(i)) or f"point_{i}" for i in range(len(points))]
        if named and source.layout is None
        else source.points_of(len(points), where)
    )
    for name, (x, y, *_), score in zip(names, points, sure, strict=False):
        yield frame, camera, name, float(x), float(y), float(score), source.name, who
