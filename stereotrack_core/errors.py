"""Errors that a person reads: what is wrong, where, and what to do about it."""

from __future__ import annotations

import difflib
import pickle
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

_MOST_ALIKE = 6
_MOST_OF_A_VALUE = 200  # characters of a value that a message quotes
_MOST_OF_A_PLACE, _MOST_OF_A_REMEDY = 1000, 4000
"""Longer than any path and than the list of all parameters that a person may have to see."""

_CONTROL = r"\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff"
_NOT_IN_TEXT = re.compile(f"[{_CONTROL}]")
_NOT_IN_A_LINE = re.compile(f"[\t\n{_CONTROL}]")


class InputError(Exception):
    """Something that the user gave us is wrong.

    `what` is wrong, as a clause without a full stop, is in the file and key or the option `where`,
    and `remedy` would be right. All three may quote files: control characters are spelled out, and
    the middle of what is very long is left out.
    """

    def __init__(self, what: str, where: Path | str = "", remedy: str = "") -> None:
        self.what = what = one_line(shortened(what, 2 * _MOST_OF_A_VALUE))
        self.where = where = one_line(shortened(str(where), _MOST_OF_A_PLACE))
        self.remedy = remedy = one_line(shortened(remedy, _MOST_OF_A_REMEDY))
        sentence = f"{where}: {what}" if where else what
        super().__init__(f"{sentence}. {remedy}".strip() if remedy else sentence)

    def __reduce__(self) -> tuple[Any, ...]:
        """As it is, its sentence unabridged: sent by a process, it arrives the same."""
        return _as_it_was, (type(self), self.args, vars(self))


def _as_it_was(
    kind: type[InputError], args: tuple[Any, ...], facts: Mapping[str, Any]
) -> InputError:
    error = kind.__new__(kind, *args)
    vars(error).update(facts)
    return error


class Cancelled(Exception):
    """Long work was stopped on request; what was finished before is kept."""


def portable(error: Exception) -> Exception:
    """An exception that another process can be sent; one that says the same where it cannot."""
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301 - our own object
    except Exception:  # noqa: BLE001 - whatever it may be that pickle cannot take
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


def visible(text: str) -> str:
    r"""Text in which control characters are spelled out, as ``\u001b``; lines stay lines.

    Also those that turn the direction of writing: a terminal or a label would obey them.
    """
    return _NOT_IN_TEXT.sub(_spelled_out, text)


def one_line(text: str) -> str:
    """The same without tabulators and ends of lines."""
    return _NOT_IN_A_LINE.sub(_spelled_out, text)


def shortened(text: str, most: int = _MOST_OF_A_VALUE) -> str:
    """Text whose middle is left out where it has more than `most` characters."""
    half = most // 2
    return text if len(text) <= most else f"{text[:half]} … {text[-half:]}"


def _spelled_out(sign: re.Match[str]) -> str:
    return f"\\u{ord(sign.group()):04x}"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``Did you mean model_points? `` for a name that is not known, to begin a remedy with.

    Names that are spelled much alike come first, then those that hold it or that it holds;
    empty where there is none.
    """
    names = sorted(known)
    alike = difflib.get_close_matches(name.lower(), names, cutoff=0.7)
    holding = [one for one in names if name and (name in one or one in name)]
    alike = list(dict.fromkeys([*alike, *holding]))[:_MOST_ALIKE]
    return f"Did you mean {' or '.join(alike)}? " if alike else ""


Severity: TypeAlias = Literal["error", "warning", "note"]

CorrectionKind: TypeAlias = Literal[
    "transpose", "scale_translation", "exchange_pair", "exchange_views", "shift_frames",
    "shift_left",
]  # fmt: skip
"""What is changed: the first two in the calibration, the others in the description."""


@dataclass(frozen=True)
class Correction:
    """What has to be changed in one file of a recording, as data that can be stored and tested.

    `names` are cameras or views; `amount` is a factor or a number of frames.
    """

    kind: CorrectionKind
    names: tuple[str, ...] = ()
    amount: float = 1.0


@dataclass(frozen=True)
class Finding:
    """Something about a recording that is wrong (error), doubtful (warning) or good to know (note).

    `where` is a file and key, a view or camera; `what` a clause without a full stop; `remedy` a
    sentence; `correction` what would be changed, where one cause is named and that is mechanical.
    """

    severity: Severity
    where: str
    what: str
    remedy: str
    correction: Correction | None = None

    @staticmethod
    def of(error: InputError) -> Finding:
        """The finding that an error of reading is."""
        return Finding("error", error.where, error.what, error.remedy)
