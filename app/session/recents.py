"""Recordings and projects that were opened last, and when."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import datetime
from itertools import zip_longest
from pathlib import Path

from PySide6.QtCore import QSettings

from stereotrack_core.project.whereabouts import SUFFIX

from ..services.stored import stored_texts

_PATHS = "recent"
_DATES = "recent_dates"
MOST_RECENT = 10


@dataclass(frozen=True)
class Recent:
    """A recording folder or project file, and when it was opened last."""

    path: Path
    opened: datetime | None = None
    """None where that is not known."""

    @property
    def when(self) -> str:
        """``2026-11-25 14:10``; empty where it is not known."""
        return f"{self.opened:%Y-%m-%d %H:%M}" if self.opened is not None else ""

    def says(self) -> str:
        """Name, date and folder, in one line."""
        return "   ".join(
            part for part in (self.path.name, self.when, str(self.path.parent)) if part
        )


def recents_in(settings: QSettings) -> list[Recent]:
    """What was opened last and is still there, the newest first."""
    paths = stored_texts(settings, _PATHS) or []
    dates = stored_texts(settings, _DATES) or []
    known = [
        Recent(Path(path), _date(date or ""))
        for path, date in zip_longest(paths, dates[: len(paths)])
    ]
    return [one for one in known if os.path.isdir(one.path) or is_project(one.path)]


def remember(settings: QSettings, path: Path, now: datetime) -> None:
    """Put a recording or project at the head of the list."""
    others = [one for one in recents_in(settings) if one.path != path]
    _store(settings, [Recent(path, now), *others][:MOST_RECENT])


def forget_all(settings: QSettings) -> None:
    """Empty the list."""
    _store(settings, [])


def is_project(path: Path) -> bool:
    """Whether a path looks like a project file."""
    return path.suffix == SUFFIX and os.path.isfile(path)


def _store(settings: QSettings, recents: list[Recent]) -> None:
    settings.setValue(_PATHS, [str(one.path) for one in recents])
    dates = [one.opened.isoformat("T", "seconds") if one.opened else "" for one in recents]
    settings.setValue(_DATES, dates)


def _date(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        return None
