"""Labels of other tools, and what their names mean: landmarks, and pictures of cameras."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.clicks_csv import ClicksFile
from stereotrack_core.recording.csv_table import LARGEST
from stereotrack_core.recording.description import Recording

_SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_LAST_NUMBER = re.compile(r"(\d+)(?!.*\d)")


@dataclass(frozen=True)
class NameMap:
    """Which landmark every name of another tool means.

    Attributes
    ----------
    known : mapping from their name to ours
    left_out : tuple of str
        Their names that mean none of ours.
    """

    known: Mapping[str, str]
    left_out: tuple[str, ...] = field(default=())


@dataclass(frozen=True)
class Labels(ClicksFile):
    """Clicks from another tool.

    Attributes
    ----------
    left_out : tuple of str
        Names in the file that mean none of our landmarks.
    """

    left_out: tuple[str, ...] = ()


def map_names(
    theirs: Iterable[str],
    ours: Sequence[str],
    stated: Mapping[str, str] | None = None,
    *,
    where: str = "",
) -> NameMap:
    """Match names of landmarks; only what is said or means the same place is taken.

    ``LElbow``, ``left-elbow``, ``Elbow_L`` are ``left_elbow``. A wrist is not matched with a hand:
    the hand's landmark is half way to the tip of the middle finger.

    Parameters
    ----------
    stated : mapping from their name to ours
        What the person says; it goes before everything else.
    where : str
        File, for complaints.

    Raises
    ------
    InputError
        Where none matches, two mean the same landmark, or a stated name is not known.
    """
    theirs = tuple(dict.fromkeys(theirs))
    stated = stated or {}
    for one, two in stated.items():
        if one not in theirs:
            raise InputError(
                f"the file has no landmark {one!r}",
                where=where,
                remedy=f"Its landmarks are {_list(theirs)}.",
            )
        if two not in ours:
            raise InputError(
                f"unknown landmark {two!r}",
                where=where,
                remedy=f"The landmarks are {_list(ours)}.",
            )
    by_words = {_words(name): name for name in ours}
    known: dict[str, str] = {}
    for name in theirs:
        own = stated.get(name) or by_words.get(_words(name))
        if own is None:
            continue
        twice = next((one for one, two in known.items() if two == own), None)
        if twice is not None:
            raise InputError(
                f"{twice!r} and {name!r} both correspond to {own}",
                where=where,
                remedy="State which one to use, for example with --name THEIRS=OURS.",
            )
        known[name] = own
    if not known:
        raise InputError(
            f"none of its landmarks is known (it has {_list(theirs)})",
            where=where,
            remedy=f"The landmarks are {_list(ours)}. State the correspondences with --name "
            "THEIRS=OURS.",
        )
    return NameMap(known, tuple(name for name in theirs if name not in known))


def camera_of(path: str, recording: Recording, stated: str | None, *, where: str) -> str:
    """The camera that a picture or video of that name is of.

    A view's name means its reference image. Looked for in the folders of the path, from the last
    to the first, then in the words of the file's name.

    Raises
    ------
    InputError
        Where no camera, or more than one, can be meant.
    """
    known = {view.name: view.image.camera for view in recording.views}
    known |= {camera: camera for camera in recording.cameras}
    if stated is not None:
        if stated not in known:
            raise InputError(
                f"the recording has no camera {stated!r}",
                where=where,
                remedy=f"The cameras of the recording are {_list(tuple(known))}.",
            )
        return known[stated]
    pure = PurePosixPath(path.replace("\\", "/"))
    for part in reversed(pure.parts[:-1]):
        if part in known:
            return known[part]
    stem = pure.name.split(".")[0]
    found = [
        name for name in known if re.search(rf"(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z])", stem)
    ]
    longest = [name for name in found if not any(name != one and name in one for one in found)]
    if len(longest) != 1:
        raise InputError(
            f"the camera of {path!r} cannot be determined",
            where=where,
            remedy="Give it with --camera. The cameras of the recording are "
            f"{_list(tuple(known))}.",
        )
    return known[longest[0]]


def known_camera(name: str, recording: Recording, *, where: str) -> Camera:
    """A camera of the recording.

    Raises
    ------
    InputError
        Where there is none of that name.
    """
    camera = recording.cameras.get(name)
    if camera is None:
        raise InputError(
            f"the recording has no camera {name!r}",
            where=where,
            remedy=f"Its cameras are {_list(tuple(recording.cameras))}. Rename the camera in the "
            "file, or remove its labels.",
        )
    return camera


def frame_of(path: str, *, where: str) -> int:
    """The frame that a numbered picture is of: the last number of its name.

    Raises
    ------
    InputError
        Where there is none.
    """
    stem = PurePosixPath(path.replace("\\", "/")).name.split(".")[0]
    match = _LAST_NUMBER.search(stem)
    if match is None:
        raise InputError(
            f"the image name {path!r} contains no number",
            where=where,
            remedy="The last number in the name must be the frame, counted from 0.",
        )
    return checked_frame(float(match.group(1)), where=where)


def checked_frame(number: float, *, where: str) -> int:
    """The number of a frame.

    Raises
    ------
    InputError
        Where no recording has a frame of that number.
    """
    if not 0 <= number <= LARGEST or number != int(number):
        raise InputError(
            f"{number:g} is not a frame number", where=where, remedy="Frames are counted from 0."
        )
    return int(number)


def _words(name: str) -> tuple[str, ...]:
    """Words of a name with the side first: ``Elbow_L`` becomes ``left``, ``elbow``."""
    words = [word.lower() for word in _WORD.findall(name)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    return (*sides, *(word for word in words if word not in _SIDES))


def _list(names: Sequence[str]) -> str:
    shown = ", ".join(names[:12])
    return f"{shown} and {len(names) - 12} more" if len(names) > 12 else shown
