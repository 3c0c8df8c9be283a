"""What is worth telling about a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stereotrack_core.errors import InputError

Severity: TypeAlias = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """Something about a recording that is wrong (error), doubtful (warning) or good to know.

    Attributes
    ----------
    severity : {"error", "warning", "note"}
    where : str
        File and key, view or camera.
    what : str
        What is found, as a clause without a full stop.
    remedy : str
        What to do about it, as a sentence.
    """

    severity: Severity
    where: str
    what: str
    remedy: str

    @staticmethod
    def of(error: InputError) -> Finding:
        """The finding that an error of reading is."""
        return Finding("error", error.where, error.what, error.remedy)
