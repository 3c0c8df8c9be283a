"""Settings of an earlier start, whatever has become of their file."""

from __future__ import annotations

from typing import TypeVar

from PySide6.QtCore import QByteArray, QSettings

T = TypeVar("T")


def stored_text(settings: QSettings, key: str) -> str:
    """A text; empty where there is none."""
    return _of_kind(settings.value(key), str) or ""


def stored_texts(settings: QSettings, key: str) -> list[str] | None:
    """Texts; None where there are none. A single one comes back from the file by itself."""
    value = settings.value(key)
    if isinstance(value, str):
        return [value]
    texts = _of_kind(value, list)
    return None if texts is None else [text for text in texts if isinstance(text, str)]


def stored_bytes(settings: QSettings, key: str) -> QByteArray | None:
    """What a widget says about its arrangement."""
    return _of_kind(settings.value(key), QByteArray)


def _of_kind(value: object, kind: type[T]) -> T | None:
    return value if isinstance(value, kind) else None
