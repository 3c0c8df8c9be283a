"""Files of labels: what is known about one, what its names mean, and the clicks that it gives."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TypeVar

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.tables import LARGEST

Item = TypeVar("Item")

_SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_NUMBER = re.compile(r"\d+")


PLACES_ALONE = ("flag", "sigma", "visibility")
"""What a file cannot say that has nothing but places."""


@dataclass(frozen=True)
class Labels:
    """Clicks of a file."""

    clicks: tuple[Click, ...]  # in the order of the file; what has problems is left out
    problems: tuple[InputError, ...]
    """Everything wrong with it, each with its place and what would be right."""
    left_out: tuple[str, ...] = ()  # names in the file that mean none of our landmarks
    unstated: tuple[str, ...] = ("flag", "sigma")  # fields of a click that the file cannot say

    def checked(self) -> tuple[Click, ...]:
        """The clicks, where there are no problems.

        Raises InputError: the first problem, with the number of the others.
        """
        if not self.problems:
            return self.clicks
        first, others = self.problems[0], len(self.problems) - 1
        more = f" ({others} more problem{'s' if others > 1 else ''} in this file)" if others else ""
        raise InputError(f"{first.what}{more}", where=first.where, remedy=first.remedy)


@dataclass(frozen=True)
class LabelSource:
    """A file of another tool, and what a person has said about it."""

    path: Path
    recording: Recording
    landmarks: Sequence[str]  # ours
    camera: str | None = None  # camera or view that the file is of, where it does not say so itself
    names: Mapping[str, str] | None = None

    def labels(
        self,
        theirs: Iterable[str],
        items: Iterable[Item],
        read: Callable[[Item, Mapping[str, str]], Iterable[Click]],
    ) -> Labels:
        """Clicks of all items; where one cannot be read that is a problem, and the others are.

        Raises InputError where none of the landmarks is known.

        Parameters
        ----------
        theirs : names of the file's landmarks
        items : rows, annotations or frames of the file
        read : gives the clicks of an item, with the mapping from their landmark to ours
        """
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

    def camera_of(self, picture: str, where: str) -> str:
        """The camera that a picture or video of that name is of."""
        return camera_of(picture, self.recording, self.camera, where=where)


def pictures_of(
    clicks: Iterable[Click], names: Sequence[str], recording: Recording, path: Path
) -> list[tuple[Camera, int, dict[str, Click]]]:
    """Clicks of these landmarks by picture: camera, frame, and the clicks by landmark, in order.

    InputError where the recording has no such camera.
    """
    pictures: dict[tuple[str, int], dict[str, Click]] = {}
    for click in clicks:
        if not click.deleted and click.landmark in names:
            pictures.setdefault((click.camera, click.frame), {})[click.landmark] = click
    for name, _ in sorted(pictures):
        if name not in recording.cameras:
            raise InputError(
                f"the recording has no camera {name!r}",
                where=str(path),
                remedy=f"Its cameras are {_list(tuple(recording.cameras))}. Rename the camera in "
                "the file, or remove its labels.",
            )
    return [(recording.cameras[key[0]], key[1], own) for key, own in sorted(pictures.items())]


def stated_names(pairs: Iterable[str], where: str = "") -> dict[str, str]:
    """Names as a person types them, ``THEIRS=OURS``; empty parts are passed over.

    Raises InputError where a part is no pair of names.
    """
    names = {}
    for text in filter(None, map(str.strip, pairs)):
        theirs, sign, ours = (part.strip() for part in text.partition("="))
        if not (sign and theirs and ours):
            raise InputError(
                f"{text!r} cannot be read",
                where=where,
                remedy="Write THEIRS=OURS, for example left_wrist=left_hand.",
            )
        names[theirs] = ours
    return names


def map_names(
    theirs: Iterable[str],
    ours: Sequence[str],
    stated: Mapping[str, str] | None = None,
    *,
    where: str = "",
) -> dict[str, str]:
    """Ours of their names of landmarks; only what is said or means the same place is taken.

    ``LElbow``, ``left-elbow``, ``Elbow_L`` are ``left_elbow``. A wrist is not matched with a hand:
    the hand's landmark is half way to the tip of the middle finger.

    `stated` mapping from their name to ours, what the person says; it goes before everything else.
    `where`: file, for complaints.

    Raises InputError where none matches, two mean the same landmark, or a stated name is not known.
    """
    theirs, stated = tuple(dict.fromkeys(theirs)), stated or {}
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
    return known


def camera_of(path: str, recording: Recording, stated: str | None, *, where: str) -> str:
    """The camera that a picture or video of that name is of.

    A view's name means its reference image. Looked for in the folders of the path, from the last
    to the first, then in the words of the file's name.

    InputError where no camera, or more than one, can be meant.
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


def frame_of(path: str, *, where: str) -> int:
    """The frame that a numbered picture is of: the last number of its name.

    InputError where there is none.
    """
    stem = PurePosixPath(path.replace("\\", "/")).name.split(".")[0]
    numbers = _NUMBER.findall(stem)
    if not numbers:
        raise InputError(
            f"the image name {path!r} contains no number",
            where=where,
            remedy="The last number in the name must be the frame, counted from 0.",
        )
    return checked_frame(float(numbers[-1]), where=where)


def checked_frame(number: float, *, where: str) -> int:
    """The number of a frame; InputError where no recording has a frame of that number."""
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
