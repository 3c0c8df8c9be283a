"""What the thesis reports: the numbers of its tables and figures, with their places.

Julius Ziegler, Tracking der artikularen Bewegung des Oberkörpers in Stereobildfolgen, Diplomarbeit,
Universität Karlsruhe (TH), 2005, chapter 4. Errors are means over all frames of real recordings
against a reference that it takes to be good to 10 degrees (page 49).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from stereotrack_core.evaluation.summary import ERROR_MEASURES

SOURCE = (
    "J. Ziegler, Tracking der artikularen Bewegung des Oberkörpers in Stereobildfolgen, "
    "Diplomarbeit, Universität Karlsruhe, 2005"
)

REFERENCE_GOOD_TO_DEG = 10.0
"""Section 4.1, page 49: ten pixels of annotation error, estimated to be 10 degrees."""

ROWS = ERROR_MEASURES[:5]
"""Measure, name and unit of every row that all four tables have."""


@dataclass(frozen=True, eq=False)
class ThesisTable:
    """A table of the thesis."""

    number: str
    page: int
    title: str
    columns: tuple[str, ...]
    values: Mapping[str, tuple[float, ...]]
    remark: str
    """What the thesis itself says about it."""

    @property
    def source(self) -> str:
        """Where the numbers stand."""
        return f"table {self.number}, page {self.page}"


def _values(*rows: tuple[float, ...]) -> Mapping[str, tuple[float, ...]]:
    named = zip((name for name, _, _ in ROWS), rows, strict=True)
    return MappingProxyType(dict(named))


TABLE_4_1 = ThesisTable(
    "4.1",
    51,
    "Results with the reference parameters",
    ("P1", "P2", "P3", "P4", "together"),
    _values(
        (65, 53, 85, 67, 67),
        (9.1, 8.2, 11.2, 9.2, 9.4),
        (9.5, 13.6, 16.4, 16.1, 13.9),
        (22.0, 33.5, 40.3, 32.8, 32.1),
        (27.6, 25.6, 27.8, 42.3, 30.8),
    ),
    "P3 and P4 are slightly worse because of low-contrast clothes and more difficult motions.",
)

TABLE_4_2 = ThesisTable(
    "4.2",
    51,
    "Number of sampled model points m",
    ("m = 24", "m = 40", "m = 64", "m = 120"),
    _values(
        (89, 71, 67, 83),
        (10.8, 9.1, 9.4, 9.3),
        (18.5, 13.7, 13.9, 13.1),
        (41.4, 31.8, 32.1, 31.9),
        (41.9, 31.1, 30.8, 32.0),
    ),
    "The gain is smaller than expected, except from m = 24.",
)

TABLE_4_3 = ThesisTable(
    "4.3",
    52,
    "Two cameras instead of four",
    ("NS", "NOSW"),
    _values((64, 62), (7.6, 8.8), (12.1, 13.1), (34.1, 29.4), (39.8, 31.8)),
    "P3 is omitted: early on, only camera S saw it, and the arms were never found again.",
)

TABLE_4_4 = ThesisTable(
    "4.4",
    53,
    "Average proportions for everyone",
    ("averaged", "individual"),
    _values((75, 67), (9.4, 9.4), (14.2, 13.9), (43.9, 32.1), (35.9, 30.8)),
    "The arms are tracked significantly worse with average proportions.",
)

TABLES: tuple[ThesisTable, ...] = (TABLE_4_1, TABLE_4_2, TABLE_4_3, TABLE_4_4)


@dataclass(frozen=True)
class ThesisMotion:
    """A motion that the thesis shows in pictures and as curves of its errors (section 4.3)."""

    pictures: str
    curves: str
    """`pictures` and `curves`: numbers of the figures."""
    page: int
    """Of the curves."""
    recording: str
    segment: str
    title: str
    frames: tuple[int, ...]
    """Frame numbers of its pictures."""
    remark: str
    """What it says about the errors; the curves themselves are not legible in the scan."""


MOTIONS: tuple[ThesisMotion, ...] = (
    ThesisMotion(
        "4.5", "4.6", 57, "P4", "whip", "whip", (1479, 1507, 1577, 1651, 1753),
        "Tracked reliably; about 20 degrees on average.",
    ),
    ThesisMotion(
        "4.7", "4.8", 59, "P2", "travolta", "Travolta", (412, 421, 436, 443, 450),
        "Tracked equally well.",
    ),
    ThesisMotion(
        "4.9", "4.10", 61, "P3", "tie-shoes", "tying shoes", (113, 148, 230, 312, 328),
        "Up to 170 degrees off at times. After the person has stood up, at about frame 320, the "
        "errors soon become small again.",
    ),
    ThesisMotion(
        "4.11", "4.12", 62, "P4", "cross-arms", "crossing arms", (390, 455, 488, 503, 520),
        "The arms were crossed from frame 455 to 505. The pose is wrong and unstable there, and "
        "correct again only from frame 520.",
    ),
)  # fmt: skip

STEREO_MS_PER_VIEW = 50.0
SEGMENTATION_MS = 130.0
FILTER_MS = 250.0
"""Sections 4.2.2 and 5, pages 52 and 66: for m = 64, on a machine of 2005."""
