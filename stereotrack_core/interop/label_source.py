"""Files of labels: what is known about one, what its names mean, and the clicks that it gives."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

from stereotrack_core.annotation.click import Click, origin_of_source
from stereotrack_core.counting import typed_number
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import words_of
from stereotrack_core.tables import LARGEST

Item = TypeVar("Item")
_NUMBER = re.compile(r"\d+")
PLACES_ALONE = ("flag", "sigma", "visibility")  # what a file cannot say that has nothing but places


PROVENANCE = {**{n: n for n in ("source", "sigma", "flag")}, "annotator": "who", "time": "at"}
"""Names that files have for what is known of a click besides its place, and its fields."""


def provenance_of_click(click: Click) -> dict[str, str | float]:
    """Provenance of a click as files state it, by :data:`PROVENANCE`; empty if unknown."""
    values = {name: getattr(click, own) for name, own in PROVENANCE.items()}
    return {name: "" if value is None else value for name, value in values.items()}


def stated_provenance(stated: Mapping[str, object], where: str) -> dict[str, Any]:
    """Fields of a click from what a file states by :data:`PROVENANCE`; InputError for nonsense."""
    texts = {name: str(stated.get(name) or "") for name in PROVENANCE}
    sigma, time = texts["sigma"], texts["time"]
    what = f"{sigma!r} is not a standard deviation in pixels"
    try:
        known = float(sigma) if sigma else None
        if known is not None and not 0.0 < known < math.inf:
            raise ValueError
        what = f"{time!r} is not a time such as 2026-05-01T12:00:00"
        if time:
            datetime.fromisoformat(time)
    except ValueError:
        raise InputError(what, where, "Leave it empty if it is not known.") from None
    told = {"flag": texts["flag"], "who": texts["annotator"], "at": time}
    return {"origin": origin_of_source(texts["source"]), "sigma": known, **told}


@dataclass(frozen=True)
class Labels:
    """Clicks of a file."""

    clicks: tuple[Click, ...]  # in the order of the file; what has problems is left out
    problems: tuple[InputError, ...]  # all that is wrong, each with its place and remedy
    left_out: tuple[str, ...] = ()  # names in the file that mean none of our landmarks
    unstated: tuple[str, ...] = ("flag", "sigma")  # fields of a click that the file cannot say

    def checked(self) -> tuple[Click, ...]:
        """The clicks; InputError with the first problem and the number of the others, if any."""
        if not self.problems:
            return self.clicks
        first, others = self.problems[0], len(self.problems) - 1
        more = f" ({others} more problem{'s' if others > 1 else ''} in this file)" if others else ""
        raise InputError(f"{first.what}{more}", first.where, first.remedy)


@dataclass(frozen=True)
class LabelSource:
    """A file of another tool, and what a person has said about it."""

    path: Path
    recording: Recording
    landmarks: Sequence[str] = ()  # ours
    camera: str | None = None  # camera or view that the file is of, where it does not say so itself
    names: Mapping[str, str] = field(default_factory=dict)  # ours by the names in the file
    axes: str = ""  # axes of a trajectory that point east, north and up, if stated

    def labels(
        self,
        theirs: Iterable[str],
        items: Iterable[Item],
        read: Callable[[Item, Mapping[str, str]], Iterable[Click]],
    ) -> Labels:
        """Clicks of items, by `read` with our landmarks by `theirs`; what fails is a problem."""
        theirs = tuple(dict.fromkeys(theirs))
        known = map_names(theirs, self.landmarks, self.names, where=str(self.path))
        clicks: list[Click] = []
        problems: list[InputError] = []
        for item in items:
            try:
                clicks += read(item, known)
            except InputError as problem:
                problems.append(problem)
        left_out = tuple(name for name in theirs if name not in known)
        return Labels(tuple(clicks), tuple(problems), left_out)

    def camera_of(self, path: str, where: str, own: str | None = None) -> str:
        """The camera that a picture or video of that name is of; `own` is what the file states.

        A view's name means its reference image. Looked for in the folders of the path, from the
        last to the first, then among the parts of the file's name, as a whole: ``trial_S1`` is not
        of ``S``. InputError where no camera, or more than one, can be meant.
        """
        known, stated = _cameras_by_name(self.recording), self.camera or own
        remedy = f"The cameras of the recording are {_list(tuple(known))}."
        if stated is not None and stated not in known:
            raise InputError(f"the recording has no camera {stated!r}", where, remedy)
        found = _named_camera(path, known) if stated is None else known[stated]
        if found is None:
            what = f"the camera of {path!r} cannot be determined"
            raise InputError(what, where, f"Give it with --camera. {remedy}")
        return found


def pictures_of(
    clicks: Iterable[Click], names: Sequence[str], recording: Recording, path: Path
) -> list[tuple[Camera, int, dict[str, Click]]]:
    """Camera, frame and clicks by landmark of each picture; InputError for an unknown camera."""
    pictures: dict[tuple[str, int], dict[str, Click]] = {}
    for click in clicks:
        if not click.deleted and click.landmark in names:
            pictures.setdefault((click.camera, click.frame), {})[click.landmark] = click
    for name, _ in sorted(pictures):
        if name not in recording.cameras:
            cameras = f"Its cameras are {_list(tuple(recording.cameras))}."
            remedy = f"{cameras} Rename the camera in the file, or remove its labels."
            raise InputError(f"the recording has no camera {name!r}", path, remedy)
    return [(recording.cameras[key[0]], key[1], own) for key, own in sorted(pictures.items())]


def stated_names(
    pairs: Iterable[str], where: str = "", form: str = "THEIRS=OURS, such as left_wrist=left_hand"
) -> dict[str, str]:
    """Names as typed, ``THEIRS=OURS``, empty parts passed over; InputError for anything else."""
    names = {}
    for text in filter(None, map(str.strip, pairs)):
        theirs, sign, ours = (part.strip() for part in text.partition("="))
        if not (sign and theirs and ours):
            raise InputError(f"{text!r} cannot be read", where, f"Write {form}.")
        names[theirs] = ours
    return names


def map_names(
    theirs: Iterable[str],
    ours: Sequence[str],
    stated: Mapping[str, str] | None = None,
    *,
    where: str = "",
    needed: bool = True,
) -> dict[str, str]:
    """Ours of their names of landmarks; only what is said or means the same place is taken.

    ``LElbow``, ``left-elbow``, ``Elbow_L`` are ``left_elbow``. A wrist is no hand: that landmark is
    half way to the tip of the middle finger. `stated` goes before everything else. InputError where
    none matches (if one is `needed`), two mean the same landmark, or a stated name is unknown.
    """
    theirs, stated = tuple(dict.fromkeys(theirs)), stated or {}
    for one, two in stated.items():
        if one not in theirs:
            what = f"the file has no landmark {one!r}"
            raise InputError(what, where, f"Its landmarks are {_list(theirs)}.")
        if two not in ours:
            what = f"unknown landmark {two!r}"
            raise InputError(what, where, f"The landmarks are {_list(ours)}.")
    by_words = {words_of(name): name for name in ours}
    known: dict[str, str] = {}
    for name in theirs:
        own = stated.get(name) or by_words.get(words_of(name))
        if own is None:
            continue
        twice = next((one for one, two in known.items() if two == own), None)
        if twice is not None:
            remedy = "State which one to use, for example with --name THEIRS=OURS."
            raise InputError(f"{twice!r} and {name!r} both correspond to {own}", where, remedy)
        known[name] = own
    if needed and not known:
        raise InputError(
            f"none of its landmarks is known (it has {_list(theirs)})",
            where,
            f"The landmarks are {_list(ours)}. State the correspondences with --name THEIRS=OURS.",
        )
    return known


def _cameras_by_name(recording: Recording) -> dict[str, str]:
    """Cameras by their own names and by those of the views whose reference image they take."""
    known = {view.name: view.image.camera for view in recording.views}
    return known | {camera: camera for camera in recording.cameras}


def _named_camera(path: str, known: Mapping[str, str]) -> str | None:
    """The one camera of `known` that a path names; None if it names none, or several."""
    pure = PurePosixPath(path.replace("\\", "/"))
    for part in reversed(pure.parts[:-1]):
        if part in known:
            return known[part]
    found = [name for name in known if _part_of_name(name).search(pure.name)]
    longest = [name for name in found if not any(name != one and name in one for one in found)]
    return known[longest[0]] if len(longest) == 1 else None


def _part_of_name(name: str) -> re.Pattern[str]:
    """Matches a name where no letter or digit is before or behind it."""
    return re.compile(rf"(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])")


class PicturePlaces:
    """Camera and frame of each of a file's pictures, also where one of its cameras is stated.

    A stated camera holds for a file of one camera. Of a file whose `pictures` (paths) lie in
    several folders, or name several cameras, it chooses those that name it; the others are left
    out. `own`: cameras that the file states of its pictures.
    """

    def __init__(
        self, source: LabelSource, pictures: Iterable[str], own: Mapping[str, str] | None = None
    ) -> None:
        self._source, self._own = source, own or {}
        self._known = _cameras_by_name(source.recording)
        self._left_out: frozenset[str] = frozenset()
        if source.camera is not None:
            paths = [one for one in dict.fromkeys(pictures) if _number_alone(one) is None]
            self._choose(paths, source.camera)

    def _choose(self, pictures: Sequence[str], stated: str) -> None:
        groups: dict[tuple[str, str | None], list[str]] = {}
        for picture in pictures:
            folder = str(PurePosixPath(picture.replace("\\", "/")).parent)
            camera = self._own.get(picture)
            if camera is None:
                camera = _named_camera(picture, self._known)
            else:
                camera = self._known.get(camera, camera)
            groups.setdefault((folder if camera is None else "", camera), []).append(picture)
        if len(groups) < 2:
            return
        camera = self._source.camera_of("", "--camera")
        if ("", camera) not in groups:
            some = [own[0] for own in groups.values()]
            several = f"{len(groups)} videos or cameras ({_list(some)})"
            what = f"the file has pictures of {several}, and none is named {stated}"
            folders = "Rename their folders after the cameras of the recording"
            raise InputError(what, self._source.path, f"{folders}, or save a file for each camera.")
        others = (own for key, own in groups.items() if key[1] != camera)
        self._left_out = frozenset(picture for own in others for picture in own)

    def camera(self, picture: str, where: str) -> str | None:
        """Camera of a picture; None if it is left out. InputError where it cannot be told."""
        if picture in self._left_out:
            return None
        return self._source.camera_of(picture, where, self._own.get(picture))

    def of(self, picture: str, where: str) -> tuple[int, str] | None:
        """Frame and camera of a numbered picture, or of a frame's number; see :meth:`camera`."""
        if (number := _number_alone(picture)) is not None:
            own = self._source.camera_of(self._source.path.name, where)
            return checked_frame(number, where=where), own
        camera = self.camera(picture, where)
        if camera is None:
            return None
        return frame_of(picture, self._known, where=where), camera


def _number_alone(text: str) -> float | None:
    try:
        return typed_number(text)
    except ValueError:
        return None


_CAMERA_NUMBER = re.compile(r"(?i)(?<![a-z])(cam|camera|view)[ _-]?\d+")


def frame_of(path: str, cameras: Iterable[str] = (), *, where: str) -> int:
    """The frame that a numbered picture is of: the last number of its name.

    A number between dots goes before it (``cam01.0012.json``). Numbers of cameras do not count,
    neither those of these names nor ``cam1``, if there is another one.

    InputError where there is none.
    """
    first, *parts = PurePosixPath(path.replace("\\", "/")).name.split(".")
    whole = [part for part in parts[-2:] if part.isdecimal()]
    rest = first
    for name in sorted(cameras, key=len, reverse=True):
        rest = _part_of_name(name).sub("", rest)
    places = (_CAMERA_NUMBER.sub("", rest), rest, " ".join((*parts[:-1], first)))
    numbers = next(filter(None, (whole, *map(_NUMBER.findall, places))), [])
    if not numbers:
        remedy = "The last number in the name must be the frame, counted from 0."
        raise InputError(f"the image name {path!r} contains no number", where, remedy)
    return checked_frame(float(numbers[-1]), where=where)


def checked_frame(number: float, *, where: str) -> int:
    """The number of a frame; InputError where no recording has a frame of that number."""
    if not 0 <= number <= LARGEST or number != int(number):
        raise InputError(f"{number:g} is not a frame number", where, "Frames are counted from 0.")
    return int(number)


def _list(names: Sequence[str]) -> str:
    shown = ", ".join(names[:12])
    return f"{shown} and {len(names) - 12} more" if len(names) > 12 else shown
