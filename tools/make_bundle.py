"""Makes a folder and an archive of the program that need no Python, and tries what they can do.

Run by the Makefile with the Python to put in; needs nothing but the standard library. The
environment in build/bundle has the locked versions and PyInstaller. The finished program is tried
without a screen, without any other Python and in another folder; where something fails, there is no
archive.
"""

import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

import bootstrap
import debian

ROOT = bootstrap.ROOT
WORK = ROOT / "build" / "bundle"
DETECTOR = WORK / "detector"  # files of the pose detector with their licence, if there is a network
SPEC = ROOT / "tools" / "bundle" / "stereotrack.spec"
# Files without which something is missing that is not tried.
PARTS = (
    *("stereotrack_app/docs/index.md", "stereotrack_app/resources/icons/play.svg"),
    "stereotrack_core/report/templates/*.html",
    *(f"PySide6/Qt/plugins/platforms/libq{name}*.so" for name in ("xcb", "offscreen", "wayland")),
)
BESIDE = ("README.md", "LICENSE", "CHANGELOG.md", "examples")

SMALL = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")
TRIED: tuple[tuple[str, ...], ...] = (
    ("--version",),
    ("--help",),
    ("simulate", "small", "--frames", "6", "--views", "NS", "--motion", "t-pose", *SMALL),
    ("info", "small"),
    ("detector",),
    ("track", "small", "-o", "run.npz", "--preset", "fast"),
    ("evaluate", "run.npz"),
    ("export", "run.npz", "-o", "run.c3d"),
    # its processes
    ("sweep", "small", "-o", "sweep.csv", "--grid", "iterations=1,2", "--workers", "2",
     "--preset", "fast", "--frames", "0:2"),
    ("report", "run.npz", "-o", "report.html"),
    ("open", "small", "--screenshot", "window.png"),
    ("demo", "--screenshot", "demo.png"),
)  # fmt: skip
MADE = ("run.npz", "run.c3d", "sweep.csv", "report.html", "window.png", "demo.png")


def locked_versions() -> str:
    """The lock as constraints, which pip takes without the reasons."""
    lines = bootstrap.LOCK.read_text(encoding="utf-8").splitlines()
    return "\n".join(line.partition("#")[0] for line in lines)


def installed() -> Path:
    """Make an environment with the program and PyInstaller; return its Python."""
    python = WORK / "environment" / "bin" / "python"
    pip = (str(python), "-m", "pip", "--disable-pip-version-check", "-qq", "--no-input", "install")
    if not python.is_file():
        bootstrap.new_environment(WORK / "environment")
    constraints = WORK / "constraints.txt"
    constraints.write_text(locked_versions(), encoding="utf-8")
    debian.say("installing the program and PyInstaller (a few minutes the first time)")
    needed = ("--requirement", str(SPEC.with_name("requirements.txt")))
    subprocess.run([*pip, "--constraint", str(constraints), *needed, str(ROOT)], check=True)
    subprocess.run([*pip, "--no-deps", "--force-reinstall", str(ROOT)], check=True)
    kept = {**os.environ, "STEREOTRACK_DETECTOR": str(DETECTOR)}
    detector = (str(python.with_name("stereotrack")), "detector", "install", "--if-missing")
    subprocess.run(detector, env=kept, check=True)
    return python


def put_together(python: Path) -> Path:
    """Have PyInstaller make the folder; return the program in it."""
    debian.say("putting the program together (some minutes)")
    made = WORK / "made"
    pyinstaller = (str(python), "-m", "PyInstaller", "--noconfirm", "--log-level", "WARN")
    places = ("--distpath", str(made), "--workpath", str(WORK / "work"))
    subprocess.run([*pyinstaller, *places, str(SPEC)], check=True)
    inside = made / "stereotrack" / "_internal"
    if shutil.which("strip"):  # their symbols have 110 MB
        libraries = (*inside.glob("vtkmodules/*.so"), *inside.glob("llvmlite/binding/*.so"))
        subprocess.run(["strip", "--strip-unneeded", *libraries], check=True)
    for name in BESIDE:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, made / "stereotrack" / name)
    if DETECTOR.is_dir():
        files = inside / "stereotrack_core" / "pose_model" / "files"
        shutil.copytree(DETECTOR, files, dirs_exist_ok=True)
    for part in PARTS:
        if not any(inside.glob(part)):
            sys.exit(f"stereotrack: bundle: PyInstaller has left out {part}")
    return made / "stereotrack" / "stereotrack"


def try_out(program: Path) -> float:
    """Use the program as a person would; return the seconds that a second start takes."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        environment = {
            "PATH": "/nowhere",
            "HOME": folder,
            "NUMBA_CACHE_DIR": str(home / "compiled"),  # nothing of this machine in the archive
            "QT_QPA_PLATFORM": "offscreen",
            "LANG": os.environ.get("LANG", "C.UTF-8"),
        }
        for words in TRIED:
            print(f"$ stereotrack {' '.join(words)}", flush=True)
            done = subprocess.run(
                [program, *words], cwd=home, env=environment, stdout=subprocess.DEVNULL
            )
            if done.returncode:
                sys.exit(f"stereotrack: bundle: this failed: {' '.join(words)}")
        missing = [name for name in MADE if not (home / name).is_file()]
        if missing:
            sys.exit(f"stereotrack: bundle: these files were not made: {', '.join(missing)}")
        begun = time.monotonic()
        subprocess.run([program, "--version"], cwd=home, env=environment, check=True)
        return time.monotonic() - begun


def packed(folder: Path) -> Path:
    """Write the archive of a folder to dist/."""
    version = re.search(
        r'__version__ = "(.+)"', (ROOT / "stereotrack_core" / "version.py").read_text("utf-8")
    )
    if version is None:
        sys.exit("stereotrack: bundle: the version is not stated")
    name = f"stereotrack-{version[1]}-{sys.platform}-{platform.machine()}"
    archive = ROOT / "dist" / f"{name}.tar.gz"
    archive.parent.mkdir(exist_ok=True)
    debian.say(f"writing {archive.relative_to(ROOT)}")
    unfinished = archive.with_suffix(".part")
    with tarfile.open(unfinished, "w:gz", compresslevel=6) as tar:
        tar.add(folder, name)
    unfinished.replace(archive)
    return archive


def megabytes(*files: Path) -> str:
    """Size of files, without links to them."""
    return f"{sum(file.stat().st_size for file in files if not file.is_symlink()) / 1e6:.0f} MB"


def main() -> int:
    """Make and try the bundle."""
    WORK.mkdir(parents=True, exist_ok=True)
    try:
        program = put_together(installed())
    except subprocess.CalledProcessError as error:
        debian.say("the program could not be put together (see above)")
        return error.returncode
    seconds = try_out(program)
    archive = packed(program.parent)
    files = [path for path in program.parent.rglob("*") if path.is_file()]
    print(f"{program.parent}: {megabytes(*files)}, starts in {seconds:.1f} s (--version)")
    print(f"{archive}: {megabytes(archive)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
