"""Small files in place of the detector's, for tests of their installation."""

import hashlib
import io
import tarfile
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from stereotrack_core.pose_model import installation
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE, HEAVY, MODEL_FILES, ModelFile

CONTENTS = {one.name: f"content of {one.name}".encode() for one in MODEL_FILES}
LARGE = b"content of the larger network"


def _known(file: ModelFile, content: bytes) -> ModelFile:
    return replace(file, size=len(content), sha256=hashlib.sha256(content).hexdigest())


def use_small_files(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Let these files be the right ones, and this the user's folder, which need not exist."""
    monkeypatch.setattr(
        installation, "MODEL_FILES", tuple(_known(one, CONTENTS[one.name]) for one in MODEL_FILES)
    )
    monkeypatch.setattr(installation, "HEAVY", _known(HEAVY, LARGE))
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return folder


def wheel(path, contents=CONTENTS):
    """A wheel with these contents where MediaPipe's has the files."""
    with zipfile.ZipFile(path, "w") as made:
        for one in MODEL_FILES:
            if one.name in contents:
                made.writestr(f"{one.place}/{one.name}", contents[one.name])
    return path


def npm_archive(path, content=LARGE):
    """An archive with the larger network where MediaPipe's npm package has it."""
    with tarfile.open(path, "w:gz") as made:
        entry = tarfile.TarInfo(f"{HEAVY.place}/{HEAVY.name}")
        entry.size = len(content)
        made.addfile(entry, io.BytesIO(content))
    return path
