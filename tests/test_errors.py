"""Suggestions in place of names that are not known."""

import pytest

from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.tracking.settings import Settings


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("acurate", "Did you mean accurate? "),
        ("Thesis", "Did you mean thesis? "),
        ("late", "Did you mean late_hands? "),
        ("", ""),
        ("quite different", ""),
    ],
)
def test_what_may_have_been_meant(name, meant):
    assert did_you_mean(name, ["accurate", "thesis", "late_hands"]) == meant


def test_parameters_name_what_is_near_or_else_all():
    with pytest.raises(InputError, match=r"'model_pionts'\. Did you mean model_points\?$"):
        Settings().replaced(model_pionts=3)
    with pytest.raises(InputError, match=r"'qqq'\. Known are: .*, model_points, "):
        Settings().replaced(qqq=3)
