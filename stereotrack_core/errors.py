"""Errors that a person reads: what is wrong, where, and what to do about it."""

import difflib
from collections.abc import Iterable

_MOST_ALIKE = 6


class InputError(Exception):
    """Something that the user gave us is wrong.

    Parameters
    ----------
    what : str
        What is wrong, as a clause without a full stop.
    where : str, optional
        File and key, or option, in which it is wrong.
    remedy : str, optional
        What would be right.
    """

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what = what
        self.where = where
        self.remedy = remedy
        sentence = f"{where}: {what}" if where else what
        super().__init__(f"{sentence}. {remedy}".strip() if remedy else sentence)


class Cancelled(Exception):
    """Long work was stopped on request; what was finished before is kept."""


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
