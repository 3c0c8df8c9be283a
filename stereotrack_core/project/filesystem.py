"""Whether a file is on a network drive, where SQLite's write-ahead log is not safe."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

MOUNTS = Path("/proc/self/mounts")
DRIVE_REMOTE = 4
"""What Windows' GetDriveTypeW says of a drive of the network."""

NETWORK_TYPES = frozenset(
    {
        *("9p", "afp", "afpfs", "afs", "beegfs", "ceph", "cifs", "coda", "davfs", "davfs2"),
        *("drvfs", "fuse.davfs2", "fuse.gcsfuse", "fuse.glusterfs", "fuse.rclone"),
        *("fuse.s3fs", "fuse.sshfs", "gfs2", "glusterfs", "gpfs", "lustre", "ncpfs", "nfs"),
        *("nfs4", "ocfs2", "orangefs", "smb3", "smbfs", "vboxsf", "virtiofs", "webdav"),
    }
)
"""File systems whose shared memory is not shared between the machines that write to them."""

Mount = tuple[str, str]
"""Where a file system is mounted, and its type."""


def network_type(path: Path, mounts: Sequence[Mount] | None = None) -> str | None:
    """Type of the network file system that holds `path`; None for a drive of this machine.

    Parameters
    ----------
    path : Path
        A file or folder; need not exist.
    mounts : sequence of (str, str), optional
        Mount points and types; the machine's own without it.
    """
    place = os.path.realpath(path)
    if mounts is None and sys.platform == "win32":
        return _windows_type(place)
    found = ("", "")
    for mounted, kind in machine_mounts() if mounts is None else mounts:
        inside = place == mounted or place.startswith(mounted.rstrip("/") + "/")
        if inside and len(mounted) >= len(found[0]):
            found = (mounted, kind)
    return found[1] if found[1] in NETWORK_TYPES else None


def machine_mounts() -> tuple[Mount, ...]:
    """What is mounted where; nothing where the machine does not tell."""
    try:
        if sys.platform == "darwin":
            listed = subprocess.run(
                ["/sbin/mount"], capture_output=True, text=True, check=False, timeout=5
            )
            return mounts_of_macos(listed.stdout)
        return mounts_of_linux(MOUNTS.read_text(encoding="utf-8", errors="surrogateescape"))
    except (OSError, subprocess.TimeoutExpired):
        return ()


def mounts_of_linux(text: str) -> tuple[Mount, ...]:
    """Mounts in the layout of ``/proc/mounts``, where spaces in paths are written as octal."""
    rows = (line.split(" ") for line in text.splitlines())
    return tuple((_unescaped(row[1]), row[2]) for row in rows if len(row) >= 3)


def _unescaped(path: str) -> str:
    for code, sign in (("\\040", " "), ("\\011", "\t"), ("\\012", "\n"), ("\\134", "\\")):
        path = path.replace(code, sign)
    return path


def mounts_of_macos(text: str) -> tuple[Mount, ...]:
    """Mounts as ``mount`` prints them: ``device on /place (type, options)``."""
    mounts = []
    for line in text.splitlines():
        place, _, options = line.partition(" on ")[2].rpartition(" (")
        if place:
            mounts.append((place, options.split(",")[0].rstrip(")")))
    return tuple(mounts)


def _windows_type(place: str) -> str | None:
    if place.startswith("\\\\"):
        return "network share"
    library = getattr(ctypes, "windll", None)
    drive = os.path.splitdrive(place)[0] + "\\"
    if library is not None and library.kernel32.GetDriveTypeW(drive) == DRIVE_REMOTE:
        return "network drive"
    return None
