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
import struct
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
# Parts of Qt for other screens than X11 and Wayland, for the network and for GTK, which would bring
# its libraries; and Qt's own texts in other languages than English.
UNUSED = (
    *("translations", "plugins/egldeviceintegrations", "plugins/generic"),
    *("plugins/networkinformation", "plugins/tls", "plugins/platformthemes/libqgtk3*"),
    *(f"plugins/platforms/libq{name}*" for name in ("eglfs", "linuxfb", "vkkhr", "vnc")),
)
BESIDE = ("README.md", "LICENSE", "CHANGELOG.md", "examples")

SMALL = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")
TRIED: tuple[tuple[str, ...], ...] = (
    ("--version",),
    ("--help",),
    ("simulate", "small", "--frames", "6", "--views", "NS", "--motion", "t-pose", *SMALL),
    ("info", "small", "--deep"),
    ("detector",),
    ("track", "small", "-o", "run.npz", "--preset", "fast"),
    ("evaluate", "run.npz", "--failures"),
    *(("export", "run.npz", "-o", f"run.{ending}") for ending in ("c3d", "trc", "csv", "bvh")),
    ("project", "create", "small"),
    ("calibrate", "export", "small/calibration.toml", "-o", "cameras.yml"),
    ("import", "recording", "small", "-o", "again", "--calibration", "small/calibration.toml"),
    # its processes
    ("sweep", "small", "-o", "sweep.csv", "--grid", "iterations=1,2", "--workers", "2",
     "--preset", "fast", "--frames", "0:2"),
    ("study", "create", "small", "-o", "all.study.toml", "--preset", "fast", "--frames", "0:2"),
    ("study", "run", "all.study.toml", "--workers", "1"),
    ("report", "run.npz", "-o", "report.html"),
    ("demo", "--screenshot", "demo.png"),
)  # fmt: skip
WORKSPACES = ("calibrate", "annotate", "track", "tune", "review")
MADE = ("run.npz", "run.c3d", "cameras.yml", "sweep.csv", "report.html", "demo.png")


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
    # Gone before PyInstaller looks what they need.
    for name in UNUSED:
        for part in WORK.glob(f"environment/**/PySide6/Qt/{name}"):
            shutil.rmtree(part) if part.is_dir() else part.unlink()
    return python


def strip(library: Path) -> None:
    """Take the symbols out, where the loader takes the library without them."""
    stripped = library.with_name("stripped")
    subprocess.run(["strip", "--strip-unneeded", "-o", stripped, library], check=True)
    content = stripped.read_bytes()
    table, size, count = struct.unpack_from("<32xQ14xHH", content)
    segments = [struct.unpack_from("<IIQQ24xQ", content, table + size * i) for i in range(count)]
    # Segments of some libraries that auditwheel has rewritten are off their pages then.
    aligned = all(kind != 1 or (place - at) % page == 0 for kind, _, at, place, page in segments)
    (stripped if aligned else library).replace(library)
    stripped.unlink(missing_ok=True)


def put_together(python: Path) -> Path:
    """Have PyInstaller make the folder; return the program in it."""
    debian.say("putting the program together (some minutes)")
    made = WORK / "made"
    pyinstaller = (str(python), "-m", "PyInstaller", "--noconfirm", "--log-level", "WARN")
    places = ("--distpath", str(made), "--workpath", str(WORK / "work"))
    subprocess.run([*pyinstaller, *places, str(SPEC)], check=True)
    inside = made / "stereotrack" / "_internal"
    if shutil.which("strip"):
        for library in inside.rglob("*.so*"):
            if not library.is_symlink():
                strip(library)
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


def try_out(program: Path, usual: Path) -> float:
    """Use the program as a person would; return the seconds that a second start takes.

    Its last window, with the scene, must look as that of `usual`, the installed program.
    """
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
        for name in WORKSPACES:
            window = ("open", "run.npz", "--workspace", name, "--frame", "2", "--screenshot")
            print(f"$ stereotrack {' '.join(window)} {name}.png", flush=True)
            subprocess.run([program, *window, f"{name}.png"], cwd=home, env=environment, check=True)
        subprocess.run([usual, *window, "usual.png"], cwd=home, env=environment, check=True)
        if (home / f"{name}.png").read_bytes() != (home / "usual.png").read_bytes():
            sys.exit(f"stereotrack: bundle: the window looks unlike the installed one: {name}")
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
        python = installed()
        program = put_together(python)
    except subprocess.CalledProcessError as error:
        debian.say("the program could not be put together (see above)")
        return error.returncode
    seconds = try_out(program, python.with_name("stereotrack"))
    archive = packed(program.parent)
    files = [path for path in program.parent.rglob("*") if path.is_file()]
    print(f"{program.parent}: {megabytes(*files)}, starts in {seconds:.1f} s (--version)")
    print(f"{archive}: {megabytes(archive)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
