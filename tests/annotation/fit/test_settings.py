"""The documentation names every parameter of the fit with its default."""

from pathlib import Path

import pytest

from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.errors import InputError

PAGE = Path(__file__).resolve().parents[3] / "docs" / "annotation-fit.md"


def test_the_page_lists_all_parameters():
    text = PAGE.read_text(encoding="utf-8")
    for row in FitSettings.rows():
        default = (
            ("no", "yes")[row.default] if isinstance(row.default, bool) else f"{row.default:g}"
        )
        assert f"| `{row.name}` | {default} | {row.unit} | {row.help} |" in text


def test_values_outside_their_range_are_refused():
    with pytest.raises(InputError, match="outlier_share"):
        FitSettings(outlier_share=0.9)
