"""One fault each, planted into a copy of a sound recording, and how it has to be named."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from stereotrack_core.doctor.slips import (
    centre_exchanged,
    focused,
    resized,
    transposed,
    undistorted,
)
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import LENGTHS, Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.writing import VideoWriter, write_recording_description

Change = Callable[[Recording, np.random.Generator], Recording | None]
"""Plants a fault; None where it cannot be planted."""


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    `cause` is a pattern of the words, without case, that a finding about the right cause has.
    """

    name: str
    plant: Change
    cause: str

    def named_by(self, findings: Sequence[Finding]) -> tuple[bool, bool]:
        """Whether errors or warnings name it, and whether one of them gives the right cause."""
        told = [one for one in findings if one.severity != "note"]
        pattern = re.compile(self.cause, re.IGNORECASE)
        right = any(pattern.search(f"{one.where}: {one.what}. {one.remedy}") for one in told)
        return bool(told), right


def copied(sound: Path, folder: Path) -> Recording:
    """A recording with the same pictures as another one, by hard links."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(sound, folder, copy_function=os.link)
    for file in (*folder.glob("*.toml"), *folder.glob("*.csv")):
        file.unlink()
        shutil.copy(sound / file.name, file)
    return open_recording(folder)


def planted(fault: Fault, sound: Path, folder: Path, seed: Sequence[int]) -> bool:
    """Make a copy with the fault; False where it cannot be planted there."""
    recording = copied(sound, folder)
    changed = fault.plant(recording, np.random.default_rng([*seed]))
    if changed is None:
        return False
    write_recording_description(changed)
    return True


def _view(recording: Recording, rng: np.random.Generator) -> View:
    return recording.views[int(rng.integers(len(recording.views)))]


def _cameras(
    recording: Recording, names: Sequence[str], change: Callable[[Camera], Camera]
) -> Recording:
    changed = {name: change(recording.cameras[name]) for name in names}
    return replace(recording, cameras={**recording.cameras, **changed})


def _with_view(recording: Recording, view: View) -> Recording:
    views = tuple(view if one.name == view.name else one for one in recording.views)
    return replace(recording, views=views)


def _of_view(change: Callable[[Camera], Camera]) -> Change:
    return lambda recording, rng: _cameras(recording, _view(recording, rng).cameras(), change)


def _of_all(change: Callable[[Camera], Camera]) -> Change:
    return lambda recording, _: _cameras(recording, list(recording.cameras), change)


def _in_millimetres(camera: Camera) -> Camera:
    old = camera.camera_from_world
    moved = RigidTransform(old.rotation, 1000.0 * old.translation)
    return replace(camera, camera_from_world=moved)


def _several(change: Change) -> Change:
    """Only where several views measure depth: of one, nobody knows it."""

    def plant(recording: Recording, rng: np.random.Generator) -> Recording | None:
        measuring = sum(view.kind != "mono" for view in recording.views)
        return change(recording, rng) if measuring > 1 else None

    return plant


def _exchange_pair(recording: Recording, rng: np.random.Generator) -> Recording | None:
    view = _view(recording, rng)
    if view.left is None:
        return None
    left = replace(view.image, camera=view.left.camera)
    image = replace(view.left, camera=view.image.camera)
    return _with_view(recording, replace(view, left=left, image=image))


def _exchange_views(recording: Recording, rng: np.random.Generator) -> Recording | None:
    if len(recording.views) < 2:
        return None
    a, b = (recording.views[int(i)] for i in rng.permutation(len(recording.views))[:2])

    def taken(own: View, other: View) -> View:
        def one(mine: Stream | None, theirs: Stream | None) -> Stream | None:
            return mine and theirs and replace(theirs, camera=mine.camera)

        image = replace(other.image, camera=own.image.camera)
        return replace(
            own, image=image, left=one(own.left, other.left), depth=one(own.depth, other.depth)
        )

    return _with_view(_with_view(recording, taken(a, b)), taken(b, a))


def _focal(recording: Recording, rng: np.random.Generator) -> Recording:
    factor = float(rng.choice([0.95, 1.05]))
    return _of_view(partial(focused, factor=factor))(recording, rng)  # type: ignore[return-value]


def _size(recording: Recording, rng: np.random.Generator) -> Recording:
    factor = float(rng.choice([0.5, 2.0]))
    return _of_view(partial(resized, factor=factor))(recording, rng)  # type: ignore[return-value]


def _base_line(recording: Recording, rng: np.random.Generator) -> Recording | None:
    view = _view(recording, rng)
    if view.left is None:
        return None
    right, left = recording.cameras[view.image.camera], recording.cameras[view.left.camera]
    factor = float(rng.choice([0.9, 1.1]))
    place = right.position_world + factor * (left.position_world - right.position_world)
    turn = left.camera_from_world.rotation
    moved = replace(left, camera_from_world=RigidTransform(turn, -turn @ place))
    return replace(recording, cameras={**recording.cameras, left.name: moved})


def _turned(recording: Recording, rng: np.random.Generator) -> Recording:
    """A view's cameras together about an axis across the image, by 3 degrees."""
    view = _view(recording, rng)
    own = recording.cameras[view.image.camera].camera_from_world
    angle = float(rng.uniform(0, np.pi))
    turn = rotation_from_vector(np.radians(3.0) * np.array([np.cos(angle), np.sin(angle), 0.0]))
    moved = own.inverse() @ RigidTransform(turn, np.zeros(3)) @ own
    return _cameras(
        recording,
        view.cameras(),
        lambda one: replace(one, camera_from_world=one.camera_from_world @ moved),
    )


def _one_turned(recording: Recording, rng: np.random.Generator) -> Recording | None:
    """One camera of a pair, about any axis but the one that moves along the rows."""
    view = _view(recording, rng)
    if view.left is None:
        return None
    axis = np.array([rng.choice([-1.0, 1.0]), 0.3 * rng.normal(), 0.5 * rng.normal()])
    turn = rotation_from_vector(np.radians(3.0) * axis / np.linalg.norm(axis))

    def change(one: Camera) -> Camera:
        old = one.camera_from_world
        moved = RigidTransform(turn @ old.rotation, turn @ old.translation)
        return replace(one, camera_from_world=moved)

    return _cameras(recording, [view.left.camera], change)


def _undistorted(recording: Recording, rng: np.random.Generator) -> Recording | None:
    view = _view(recording, rng)
    if not any(np.abs(recording.cameras[name].distortions).max() > 0.02 for name in view.cameras()):
        return None
    return _cameras(recording, view.cameras(), undistorted)


def _rate(recording: Recording, rng: np.random.Generator) -> Recording | None:
    """All pictures in videos that state the true rate, where the recording states another one."""
    views = []
    for view in recording.views:
        streams = {"image": view.image, **({"left": view.left} if view.left else {})}
        made = {key: _as_video(recording, stream) for key, stream in streams.items()}
        views.append(replace(view, **made))  # type: ignore[arg-type]
    factor = float(rng.choice([0.5, 2.0, 1.25]))
    return replace(recording, views=tuple(views), fps=recording.fps * factor)


def _as_video(recording: Recording, stream: Stream) -> Stream:
    pictures = [cv2.imread(str(one), 0) for one in _files(recording, stream)]
    height, width = pictures[0].shape
    name = f"{stream.camera}.mp4"
    with VideoWriter(
        recording.folder / name, fps=recording.fps, width=width, height=height
    ) as video:
        for picture in pictures:
            video.write(picture)
    return replace(stream, frames=name)


def _files(recording: Recording, stream: Stream) -> list[Path]:
    return sorted((recording.folder / stream.frames).parent.iterdir())


def _pictures(change: Callable[[np.ndarray], np.ndarray], *keys: str) -> Change:
    """Pictures of a view that are changed, backgrounds as well; of all its streams or of some."""

    def plant(recording: Recording, rng: np.random.Generator) -> Recording | None:
        view = _view(recording, rng)
        streams = {"left": view.left, "image": view.image, "depth": view.depth, "mask": view.mask}
        chosen = {key: s for key, s in streams.items() if s and (not keys or key in keys)}
        if not chosen:
            return None
        made = {}
        for key, stream in chosen.items():
            for file in _files(recording, stream):
                _rewrite(file, change)
            if stream.background and key not in {"depth", "mask"}:
                _rewrite(recording.folder / stream.background, change)
            made[key] = stream
        return _with_view(recording, replace(view, **made))  # type: ignore[arg-type]

    return plant


def _rewrite(file: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    picture = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    file.unlink()  # the file of the sound recording stays as it is
    cv2.imwrite(str(file), np.ascontiguousarray(change(picture)), [cv2.IMWRITE_PNG_COMPRESSION, 1])


def _half_black(picture: np.ndarray) -> np.ndarray:
    changed = picture.copy()
    changed[:, : picture.shape[1] // 2] = 0
    return changed


def _late(recording: Recording, rng: np.random.Generator) -> Recording | None:
    """One view begins 8 frames before the others, and so shows everything later."""
    if len(recording.views) < 2:
        return None
    return _shifted(recording, _view(recording, rng), 8, ("left", "image", "depth", "mask"))


def _one_late(recording: Recording, rng: np.random.Generator) -> Recording | None:
    view = _view(recording, rng)
    if view.left is None:
        return None
    return _shifted(recording, view, 3, ("left",))


def _shifted(recording: Recording, view: View, frames: int, keys: Sequence[str]) -> Recording:
    """Some streams of a view begin earlier than all others; all are equally long."""
    for one in recording.views:
        streams = {"left": one.left, "image": one.image, "depth": one.depth, "mask": one.mask}
        for key, stream in streams.items():
            if stream is not None:
                files = _files(recording, stream)
                late = one.name == view.name and key in keys
                for file in files[-frames:] if late else files[:frames]:
                    file.unlink()
    reference = recording.reference
    if reference is not None:
        kept = reference.frame >= frames
        frame = reference.frame[kept] - frames
        reference = replace(reference, frame=frame, points=reference.points[kept])
    return replace(recording, reference=reference)


def _background(recording: Recording, rng: np.random.Generator) -> Recording | None:
    if len(recording.views) < 2:
        return None
    a, b = (recording.views[int(i)] for i in rng.permutation(len(recording.views))[:2])
    if a.image.background is None or b.image.background is None:
        return None
    image = replace(a.image, background=b.image.background)
    left = a.left and b.left and replace(a.left, background=b.left.background)
    return _with_view(recording, replace(a, image=image, left=left))


def _reference(change: Callable[[np.ndarray], np.ndarray]) -> Change:
    def plant(recording: Recording, rng: np.random.Generator) -> Recording | None:
        if recording.reference is None:
            return None
        points = change(recording.reference.points)
        return replace(recording, reference=replace(recording.reference, points=points))

    return plant


def _reference_late(recording: Recording, _: np.random.Generator) -> Recording | None:
    if recording.reference is None:
        return None
    reference = replace(recording.reference, frame=recording.reference.frame + 8)
    kept = reference.frame < reference.frame[-1] - 7
    return replace(
        recording,
        reference=replace(reference, frame=reference.frame[kept], points=reference.points[kept]),
    )


def other_reference(other: Path) -> Change:
    """The reference of another recording."""

    def plant(recording: Recording, _: np.random.Generator) -> Recording | None:
        reference = open_recording(other).reference
        if recording.reference is None or reference is None:
            return None
        return replace(recording, reference=reference)

    return plant


_MIRROR = [
    LANDMARKS.index(
        {"left": name.replace("left", "right"), "righ": name.replace("right", "left")}.get(
            name[:4], name
        )
    )
    for name in LANDMARKS
]


def _large(recording: Recording, _: np.random.Generator) -> Recording | None:
    if recording.subject is None:
        return None
    lengths = {
        key: None if (length := getattr(recording.subject, key)) is None else 1.25 * length
        for key in LENGTHS
    }
    return replace(recording, subject=replace(recording.subject, **lengths))


def faults(other: Path) -> Iterator[Fault]:
    """Every kind of fault; `other` is a recording whose reference is taken for a wrong one."""
    yield Fault("pair exchanged", _exchange_pair, "left and (the )?right .*(exchanged|swapped)")
    yield Fault("views exchanged", _exchange_views, r"views .*exchanged")
    yield Fault("rotation transposed, one", _of_view(transposed), "transpose")
    yield Fault("rotation transposed, all", _of_all(transposed), "transpose")
    yield Fault("millimetres, one", _of_view(_in_millimetres), "millimet|in metres|units")
    yield Fault("millimetres, all", _of_all(_in_millimetres), "millimet|in metres|units")
    yield Fault("matrix of another size", _size, "image size")
    yield Fault("c_x and c_y exchanged", _of_view(centre_exchanged), r"c_?x.*c_?y|principal point")
    yield Fault("focal length 5 % off", _several(_focal), "focal")
    yield Fault("base line 10 % off", _several(_base_line), "base line")
    yield Fault("view turned 3 degrees", _several(_turned), "turned by")
    yield Fault("one camera turned 3 degrees", _one_turned, "turned by")
    yield Fault("distortion left out", _undistorted, "distortion")
    yield Fault("frame rate", _rate, "frames per second")
    yield Fault("reference of another recording", other_reference(other), "another recording")
    yield Fault("reference y-up", _reference(lambda p: p[..., [0, 2, 1]] * [1, 1, -1]), "y axis")
    yield Fault("reference 8 frames late", _reference_late, r"reference\.csv.* frames? .*late")
    yield Fault(
        "reference sides exchanged", _reference(lambda p: p[:, _MIRROR]),
        r"reference\.csv.*left and right .*(exchanged|swapped)",
    )  # fmt: skip
    yield Fault("subject 25 % too large", _large, r"subject\.toml.*too (large|long)")
    yield Fault("view mirrored", _pictures(lambda p: p[:, ::-1]), "mirrored")
    yield Fault("one picture mirrored", _pictures(lambda p: p[:, ::-1], "left"), "mirrored")
    yield Fault("view upside down", _pictures(lambda p: p[::-1, ::-1]), "upside down")
    yield Fault("half a picture black", _pictures(_half_black, "image"), "black")
    yield Fault("view 8 frames late", _late, r"frames .*later")
    yield Fault("one of a pair 3 frames late", _one_late, r", left: .*frames .*later")
    yield Fault("background of another view", _background, "background")
