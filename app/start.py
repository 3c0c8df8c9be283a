"""Shows the window as the program asks; where, is settled before Qt is loaded."""

import gc
import os
import signal
import sys
from collections.abc import Callable

from stereotrack_core.errors import InputError
from stereotrack_core.window import Opening

_MMAP_THRESHOLD = -3  # M_MMAP_THRESHOLD of malloc.h
WORKSPACE_NAMES = ("calibrate", "annotate", "track", "tune", "review")


def check_workspace_name(name: str | None) -> None:
    """Refuse a name that no workspace has. Raises InputError with the names that there are."""
    if name is not None and name.strip().lower() not in WORKSPACE_NAMES:
        raise InputError(
            f"there is no workspace {name!r}",
            where="--workspace",
            remedy=f"Available: {', '.join(WORKSPACE_NAMES)}.",
        )


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
    """Choose Qt's platform; a picture of the window needs no screen.

    Raises InputError where a screen is needed and none is there.
    """
    # OpenCV's wheels with a window of their own point Qt at plugins that do not fit
    os.environ.pop("QT_QPA_PLATFORM_PLUGIN_PATH", None)
    if not has_display() and not os.environ.get("QT_QPA_PLATFORM"):
        if needs_screen:
            raise InputError(
                "there is no display to show the window on",
                remedy="Give --screenshot PNG to save an image of the window, or use the commands "
                "listed by `stereotrack --help`.",
            )
        os.environ["QT_QPA_PLATFORM"] = "offscreen"
    if os.environ.get("QT_QPA_PLATFORM") == "offscreen":  # it warns about every window
        os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")


def give_back_pictures() -> None:
    """Let the GNU C library return memory of a quarter of a MiB or more at once when it is freed.

    Else it keeps freed pictures in an arena of each thread: 0.5 of 2 GB after five minutes.
    """
    import ctypes

    if sys.platform == "linux" and (give := getattr(ctypes.CDLL(None), "mallopt", None)):
        give(_MMAP_THRESHOLD, 1 << 18)


def load_qt() -> None:
    """Load Qt's libraries.

    Raises InputError where a library of the system is missing, with the command that installs it.
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


def show(opening: Opening, say: Callable[[str], None]) -> bool:
    """Show the window until it is closed; whether all went well.

    Raises InputError for what cannot be shown.
    """
    # Modules leave nothing to collect; looking took a tenth of a second. See `GarbageTimer`.
    gc.disable()
    give_back_pictures()
    _check(opening)
    prepare(needs_screen=opening.picture is None)
    # Qt reads the source of each module that is imported after it: half a second for the core's.
    from .session import session  # noqa: F401

    load_qt()
    before = signal.signal(signal.SIGINT, _leave_at_once)
    try:
        from .program import WindowProgram

        program = WindowProgram()
        context = program.context
        context.session.project.makes = opening.picture is None  # a picture leaves nothing behind
        if opening.run is not None or opening.demo is not None:
            context.view_state.change_display(keep_person=True)
        if opening.demo is not None:
            program.track_demo(opening.demo, opening.frame)
        elif opening.path is not None:
            context.session.open(
                opening.path, frame=opening.frame, workspace=opening.workspace, run=opening.run
            )
        return program.run() if opening.picture is None else program.picture(opening.picture, say)
    finally:
        signal.signal(signal.SIGINT, before)


def _leave_at_once(*_: object) -> None:
    """End the program at Ctrl-C while the window is being made.

    An exception would be raised somewhere within Qt, which swallows it or does not survive it.
    What a project says is on the drive already. A window that is shown closes instead.
    """
    os.write(2, b"Stopped.\n")
    os._exit(1)


def _check(opening: Opening) -> None:
    """Refuse at once what can be known to be wrong before a window is there."""
    path, picture = opening.path, opening.picture
    if path is not None:
        from stereotrack_core.interop.run_file import holds_run, meta_of_run
        from stereotrack_core.project.database import check_header
        from stereotrack_core.recording.folder import open_recording
        from stereotrack_core.recording.importing.sources import is_unmade
        from stereotrack_core.study.description import SUFFIX, read_study

        check_workspace_name(opening.workspace)
        if path.is_file() and path.name.endswith(SUFFIX):
            read_study(path)
        elif path.is_file() and holds_run(path):
            meta_of_run(path)
        elif picture is None and is_unmade(path):
            pass  # the window offers to make a recording of it
        elif path.is_file() and path.name != "recording.toml":
            check_header(path)
        else:
            open_recording(path.parent if path.is_file() else path)
    if picture is not None:
        folder = picture.absolute().parent
        if not folder.is_dir() or not os.access(folder, os.W_OK):
            raise InputError(
                "cannot write the image here",
                where=str(picture),
                remedy="Choose a folder that exists and that you may write to.",
            )
