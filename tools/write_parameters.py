"""Writes docs/parameters.md from the rows that the code declares: ``make docs``."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path

from stereotrack_core.parameters import ParameterRow, Value
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import BASELINES, PRESETS, preset

ABOUT = """\
# Parameters

Made by `make docs` from the rows that the code declares; do not edit it by hand. Change a parameter
with `--set name=value` on the command line or in the panel of the workbench. The columns under the
presets give their values; the last column names what the thesis decides, by its section 4.2.1 or by
its method (chapters 2 and 3). Preset `thesis` is made of these, with the defaults elsewhere. The
presets {baselines} are baselines to compare with: they differ from `accurate` in `estimator` alone.
"""
OWN = tuple(name for name in PRESETS if name not in BASELINES)
HEADINGS = ("parameter", "what it does", "unit", "accepted", *OWN, "in the thesis")


def parameters_page() -> str:
    """Text of docs/parameters.md."""
    settings = [preset(name).values() for name in OWN]
    parts = [ABOUT.format(baselines=", ".join(f"`{name}`" for name in BASELINES))]
    for group, rows in groupby(Settings.rows(), key=lambda row: row.group):
        lines = [_line(row, [values[row.name] for values in settings]) for row in rows]
        rule = _joined(["---"] * len(HEADINGS))
        parts.append("\n".join([f"## {group}\n", _joined(HEADINGS), rule, *lines]) + "\n")
    return "\n".join(parts)


def _line(row: ParameterRow, in_presets: Sequence[Value]) -> str:
    thesis = "" if row.thesis is None else _text(row.thesis)
    values = (_text(value) for value in in_presets)
    return _joined([f"`{row.name}`", row.help, row.unit, _accepted(row), *values, thesis])


def _accepted(row: ParameterRow) -> str:
    if row.type is bool:
        return "yes, no"
    if row.choices:
        return ", ".join(row.choices)
    if row.minimum is None and row.maximum is None:
        return "any"
    if row.maximum is None:
        return f"from {_text(row.minimum)}"
    if row.minimum is None:
        return f"up to {_text(row.maximum)}"
    return f"{_text(row.minimum)} to {_text(row.maximum)}"


def _text(value: Value | None) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.10g}" if isinstance(value, int | float) else str(value)


def _joined(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def main(arguments: Sequence[str]) -> int:
    """Write the page to the file that is named."""
    path = Path(arguments[0])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(parameters_page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
