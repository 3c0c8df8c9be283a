"""Suggestions in place of names that are not known."""

import pytest

from stereotrack_core.errors import InputError, did_you_mean, visible


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


def test_values_are_cut_and_control_characters_spelled_out():
    what, remedy = f"{'x' * 10_000!r} is not a number", "Write\t\u202eone."
    error = InputError(what, where="a\x1b.toml, fps\n", remedy=remedy)
    assert len(error.what) < 420
    assert error.what.startswith("'xxx")
    assert error.what.endswith("xxx' is not a number")
    assert error.where == "a\\u001b.toml, fps\\u000a"
    assert error.remedy == "Write\\u0009\\u202eone."
    assert str(error) == f"{error.where}: {error.what}. {error.remedy}"
    assert str(error).isprintable()
    assert InputError("the name 'Größe 左' is taken").what == "the name 'Größe 左' is taken"
    assert visible("two\n\tlines \ud800") == "two\n\tlines \\ud800"
