"""The calibration of a recording that is being made: of this program or of any other tool."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.interop.calibrations.deciding import Decided, completed, decide
from stereotrack_core.interop.calibrations.formats import read_foreign
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.importing.choices import Choices, cameras_of, size_of


def with_calibration(
    choices: Choices,
    paths: Sequence[Path],
    *,
    unit: str | None = None,
    convention: str | None = None,
) -> tuple[Choices, Decided | None]:
    """Choices with the cameras of files, matched by their names, and how they were read.

    A ``calibration.toml`` needs no decision. Names that are equal but for upper case, the cameras
    of a single pair, and a single camera are matched; others are left to the person, who may say
    `unit` and `convention`. InputError where a file cannot be read, ``Undecided`` where these are
    open.
    """
    if len(paths) == 1 and not (unit or convention) and _is_own(paths[0]):
        known = read_calibration(paths[0])
        choices = replace(choices, calibration=paths[0], given=None)
        return _matched(choices, list(known)), None
    sizes = {size_of(use) for use in choices.used()}
    size = sizes.pop() if len(sizes) == 1 else None
    foreign = completed(read_foreign(paths), size=size)
    matched = _matched(choices, [one.name for one in foreign.cameras])
    pairs = _pairs(matched, [one.name for one in foreign.cameras])
    decided = decide(foreign, pairs, convention=convention, unit=unit)
    return replace(matched, calibration=paths[0], given=decided.cameras), decided


def _is_own(path: Path) -> bool:
    """Whether a file can be used as it is."""
    if path.suffix.lower() != ".toml":
        return False
    try:
        read_calibration(path)
    except InputError:
        try:
            read_foreign([path])
        except InputError:
            return True  # what is wrong is said as for a calibration.toml
        return False
    return True


def _matched(choices: Choices, theirs: Sequence[str]) -> Choices:
    ours = choices.camera_names()
    lower = {name.casefold(): name for name in theirs}
    found = {name: lower[name.casefold()] for name in ours if name.casefold() in lower}
    pairs = [cameras_of(use)[0].rpartition("_")[0] for use in choices.used()
             if use.role == "left" or use.role.startswith("side")]  # fmt: skip
    if not found and len(pairs) == 1 and {"left", "right"} <= set(lower):
        found = {f"{pairs[0]}_{side}": lower[side] for side in ("left", "right")}
    if not found and len(ours) == len(theirs) == 1:
        found = {ours[0]: theirs[0]}
    known = {name: camera for name, camera in choices.cameras.items() if camera in theirs}
    return replace(choices, cameras={**found, **known})


def _pairs(choices: Choices, theirs: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Left and right cameras of the stereo views, by the names of the file."""
    names = {name: choices.cameras.get(name, name) for name in choices.camera_names()}
    views = dict.fromkeys(use.view for use in choices.used())
    both = [(names.get(f"{view}_left", ""), names.get(f"{view}_right", "")) for view in views]
    return tuple(pair for pair in both if set(pair) <= set(theirs))
