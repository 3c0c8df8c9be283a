"""Where the window is to be shown, settled before Qt is loaded."""

from __future__ import annotations

import os
import sys

from stereotrack_core.errors import InputError

_PACKAGES = (
    "libegl1 libgl1 libxkbcommon-x11-0 libdbus-1-3 libfontconfig1 libxcb-cursor0 libxcb-icccm4 "
    "libxcb-image0 libxcb-keysyms1 libxcb-render-util0 libxcb-shape0 libxcb-xinerama0"
)


def has_display() -> bool:
    """Whether there is a screen to show a window on."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def prepare(*, needs_screen: bool) -> None:
    """Choose Qt's platform.

    Parameters
    ----------
    needs_screen : bool
        Whether somebody shall see the window; a picture of it needs no screen.

    Raises
    ------
    InputError
        Where a screen is needed and none is there.
    """
    # OpenCV's wheels with a window of their own point Qt at plugins that do not fit
    os.environ.pop("QT_QPA_PLATFORM_PLUGIN_PATH", None)
    if has_display() or os.environ.get("QT_QPA_PLATFORM"):
        return
    if needs_screen:
        raise InputError(
            "there is no display to show the window on",
            remedy="Give --screenshot PNG to save an image of the window, or use the commands "
            "listed by `stereotrack --help`.",
        )
    os.environ["QT_QPA_PLATFORM"] = "offscreen"


def load_qt() -> None:
    """Load Qt's libraries.

    Raises
    ------
    InputError
        Where a library of the system is missing, with the command that installs it.
    """
    try:
        import PySide6.QtWidgets  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"Qt cannot be loaded ({error})",
            remedy=f"Install the missing libraries: sudo apt-get install {_PACKAGES}",
        ) from error
    if sys.platform == "linux" and os.environ.get("QT_QPA_PLATFORM", "xcb").startswith("xcb"):
        _check_xcb()


def _check_xcb() -> None:
    """Try the libraries of Qt's X11 plugin, which Qt would end the program for."""
    import ctypes
    from pathlib import Path

    import PySide6

    plugin = Path(PySide6.__file__).parent / "Qt" / "plugins" / "platforms" / "libqxcb.so"
    wayland_only = not os.environ.get("DISPLAY")
    if wayland_only or not plugin.is_file():
        return
    try:
        ctypes.CDLL(str(plugin))
    except OSError as error:
        raise InputError(
            f"the window cannot be shown ({error})",
            remedy=f"Install the missing libraries: sudo apt-get install {_PACKAGES}",
        ) from error
