"""Small files in place of the detector's, for tests of their installation."""

import hashlib
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from stereotrack_core.pose_model import installation
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE, MODEL_FILES

CONTENTS = {one.name: f"content of {one.name}".encode() for one in MODEL_FILES}


def use_small_files(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Let these files be the right ones, and this the user's folder, which need not exist."""
    files = tuple(
        replace(
            one,
            size=len(CONTENTS[one.name]),
            sha256=hashlib.sha256(CONTENTS[one.name]).hexdigest(),
        )
        for one in MODEL_FILES
    )
    monkeypatch.setattr(installation, "MODEL_FILES", files)
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return folder


def wheel(path, contents=CONTENTS):
    """A wheel with these contents where MediaPipe's has the files."""
    with zipfile.ZipFile(path, "w") as made:
        for one in MODEL_FILES:
            if one.name in contents:
                made.writestr(f"{one.place}/{one.name}", contents[one.name])
    return path
