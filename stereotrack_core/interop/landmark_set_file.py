"""A set of landmarks as a TOML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tomli_w

from stereotrack_core.annotation.landmark_set import LandmarkSet, landmark_set_of
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.recording.toml_table import load_toml


def read_landmark_set(path: Path) -> LandmarkSet:
    """The set that a file describes; one without a name gets the file's.

    Raises
    ------
    InputError
        Where the file cannot be read or does not describe a set; it names the landmark.
    """
    facts: dict[str, Any] = {"name": path.stem, **load_toml(path)}
    try:
        return landmark_set_of(facts)
    except InputError as error:
        where = f"{path.name}, {error.where}" if error.where else path.name
        raise InputError(error.what, where=where, remedy=error.remedy) from error


def write_landmark_set(path: Path, landmarks: LandmarkSet) -> None:
    """Write a set so that :func:`read_landmark_set` gives it again.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    facts = landmarks.facts()
    rows = [{**row, "offset": list(row["offset"])} for row in facts["landmarks"]]
    write_file(path, tomli_w.dumps({"name": facts["name"], "landmarks": rows}))
