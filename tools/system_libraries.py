"""The system libraries that Qt and VTK load: which are missing, and which packages have them.

The wheels of PySide6 and VTK carry most of what they need and expect the rest from the system.
``python tools/system_libraries.py`` (with the environment's Python) installs what is missing
where it may. Otherwise it says what to type, and ends with status 1 if the program cannot even
run without a screen, or, with ``--window``, if it cannot show a window.
"""

import ctypes
import importlib.util
import re
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import debian

# What the program needs even without a screen, and what a window on X11 needs besides.
ALWAYS = (
    "PySide6/QtWidgets.abi3.so",
    "PySide6/QtOpenGL.abi3.so",
    "PySide6/QtSvg.abi3.so",
    "PySide6/Qt/plugins/platforms/libqoffscreen.so",
    "PySide6/Qt/plugins/imageformats/libqjpeg.so",
    "vtkmodules/vtkRenderingOpenGL2*.so",
    "vtkmodules/vtkRenderingFreeType*.so",
    "vtkmodules/vtkInteractionStyle*.so",
    "cv2/cv2*.so",
)
FOR_A_WINDOW = (
    "PySide6/Qt/plugins/platforms/libqxcb.so",
    "PySide6/Qt/plugins/xcbglintegrations/*.so",
)
# VTK opens these by name while it runs, so that nothing lists them.
OPENED_BY_NAME = ("libEGL.so.1", "libGL.so.1", "libXcursor.so.1")

# Packages whose name does not follow from the library's (Debian Policy 8.1).
IRREGULAR = {
    "libz.so.1": "zlib1g",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libgobject-2.0.so.0": "libglib2.0-0",
    "libgio-2.0.so.0": "libglib2.0-0",
}


def package_of(library: str) -> str:
    """Debian package of a shared library, such as libxcb-icccm4 of libxcb-icccm.so.4.

    By Debian Policy 8.1: name and version joined, by a hyphen where the name ends with a digit,
    in lower case.
    """
    if library in IRREGULAR:
        return IRREGULAR[library]
    name, _, version = library.partition(".so.")
    hyphen = "-" if name[-1:].isdigit() and version else ""
    return f"{name}{hyphen}{version}".lower().replace("_", "-")


def missing_in(ldd_output: str) -> set[str]:
    """Libraries that ldd did not find."""
    return set(re.findall(r"^\s*(\S+) => not found", ldd_output, flags=re.MULTILINE))


def missing_libraries(patterns: Iterable[str]) -> set[str]:
    """Libraries that files of the environment link with and the system does not have."""
    files = [str(file) for pattern in patterns for file in _files(pattern)]
    try:
        ldd = subprocess.run(["ldd", *files], capture_output=True, text=True)
    except FileNotFoundError:
        return set()
    return missing_in(ldd.stdout)


def _files(pattern: str) -> list[Path]:
    package, _, rest = pattern.partition("/")
    spec = importlib.util.find_spec(package)
    places = spec.submodule_search_locations if spec else None
    return [file for place in places or () for file in sorted(Path(place).glob(rest))]


def _cannot_be_opened(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return True
    return False


def missing_now() -> tuple[set[str], set[str]]:
    """Libraries missing for any use, and those missing for a window only."""
    always = missing_libraries(ALWAYS)
    window = missing_libraries(FOR_A_WINDOW) - always
    # Without OpenGL all but the 3-D scene works.
    return always, window | {name for name in OPENED_BY_NAME if _cannot_be_opened(name)} - always


def main(arguments: Sequence[str]) -> int:
    """Install what is missing, or say what to type."""
    if not sys.platform.startswith("linux"):
        return 0
    always, window = missing_now()
    if always or window:
        packages = sorted({package_of(library) for library in always | window})
        if debian.install(packages):
            always, window = missing_now()
    if not always and not window:
        return 0
    libraries = sorted(always | window)
    debian.say(f"system libraries are missing: {', '.join(libraries)}")
    if not always:
        debian.say("without them the program works only without a display")
    debian.say(f"install them with: {debian.install_command(sorted(map(package_of, libraries)))}")
    return 1 if always or "--window" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
