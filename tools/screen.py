"""Ends with status 0 if a window can be opened here, with 1 if there is no screen."""

import os
import subprocess
import sys
from pathlib import Path

import debian

PROBE = "from PySide6.QtGui import QGuiApplication; QGuiApplication([])"


def window_opens() -> bool:
    """Whether Qt finds a screen; it ends the whole process where it does not, hence another one."""
    return subprocess.run([sys.executable, "-c", PROBE], capture_output=True).returncode == 0


def main() -> int:
    """Look for a screen; where libraries are all that is missing for one, install them."""
    on_linux = sys.platform.startswith("linux")
    if on_linux and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return 1
    if window_opens():
        return 0
    libraries = Path(__file__).with_name("system_libraries.py")
    if subprocess.run([sys.executable, libraries, "--window"]).returncode == 0 and window_opens():
        return 0
    debian.say("the configured display cannot be used; continuing without one")
    return 1


if __name__ == "__main__":
    sys.exit(main())
