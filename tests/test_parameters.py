"""Parameters: declared once, checked where they are set."""

import dataclasses
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterGroup, parameter, parsed_settings


@dataclass(frozen=True)
class Inner(ParameterGroup):
    width: float = parameter(0.5, "Shape", (0.1, 2.0), unit="m", thesis=0.4)("Width.")
    kind: str = parameter("round", "Shape", choices=("round", "flat"))("Kind.")


@dataclass(frozen=True)
class Outer(ParameterGroup):
    count: int = parameter(4, "Frame metrics", (1, None))("Count.")
    gain: float = parameter(1.0, "Frame metrics")("Gain.")
    on: bool = parameter(True, "Frame metrics")("Switch.")
    inner: Inner = dataclasses.field(default_factory=Inner)


def test_rows_come_in_order_with_everything_that_was_declared():
    rows = {row.name: row for row in Outer.rows()}
    assert list(rows) == ["count", "gain", "on", "width", "kind"]
    width = rows["width"]
    assert (width.type, width.default, width.unit, width.group) == (float, 0.5, "m", "Shape")
    assert (width.minimum, width.maximum, width.thesis) == (0.1, 2.0, 0.4)
    assert rows["kind"].choices == ("round", "flat")
    assert rows["count"].thesis is None


def test_replacing_leaves_the_original_and_reaches_into_groups():
    first = Outer()
    second = first.replaced(count="7", width="0.25", kind="flat", on="no")
    assert second.values() == {"count": 7, "gain": 1.0, "on": False, "width": 0.25, "kind": "flat"}
    assert first == Outer()
    assert second.replaced(**first.values()) == first


@given(
    count=st.integers(1, 10**6),
    gain=st.floats(allow_nan=False, allow_infinity=False),
    on=st.booleans(),
    width=st.floats(0.1, 2.0),
)
def test_what_is_printed_can_be_set(count, gain, on, width):
    made = Outer(count=count, gain=gain, on=on, inner=Inner(width=width))
    texts = [f"{name}={value}" for name, value in made.values().items()]
    assert Outer().replaced(**parsed_settings(texts)) == made


@pytest.mark.parametrize(
    ("name", "value", "right"),
    [
        ("width", 0.09, "from 0.1 to 2 m"),
        ("width", "2.1", "from 0.1 to 2 m"),
        ("width", "wide", "a number"),
        ("width", "nan", "a number"),
        ("width", None, "a number"),
        ("count", 0, "from 1"),
        ("count", 2.5, "a whole number"),
        ("count", "2.5", "a whole number"),
        ("count", float("inf"), "a whole number"),
        ("gain", float("nan"), "of any size"),
        ("gain", "inf", "a number"),
        ("gain", float("-inf"), "of any size"),
        ("on", "perhaps", "yes or no"),
        ("on", None, "yes or no"),
        ("kind", "square", "one of round, flat"),
    ],
)
def test_wrong_values_are_refused_with_a_sentence(name, value, right):
    with pytest.raises(InputError) as refused:
        Outer().replaced(**{name: value})
    assert refused.value.where == name
    assert right in refused.value.remedy
    assert repr(value) in refused.value.what


def test_both_decimal_signs_are_read_and_nothing_groups_digits():
    gain = next(row for row in Outer.rows() if row.name == "gain")
    read = {text: gain.checked(text) for text in ("0,5", "0.5", ",5", "-1,5e2", "1.500", "2")}
    assert read == {"0,5": 0.5, "0.5": 0.5, ",5": 0.5, "-1,5e2": -150.0, "1.500": 1.5, "2": 2.0}
    count, gain, *_ = Outer.rows()
    grouped = [(count, one) for one in ("1.000", "2,5", "1_000")]
    for row, text in [*grouped, (gain, "1.234,5"), (gain, "1 234"), (gain, "5_0")]:
        with pytest.raises(InputError, match="is not a valid value"):
            row.checked(text)


def test_unknown_names_are_refused_with_what_may_have_been_meant_or_all_that_are_known():
    with pytest.raises(InputError) as refused:
        Outer().replaced(widht=1.0)
    assert "'widht'" in refused.value.what
    assert refused.value.remedy == "Did you mean width?"
    with pytest.raises(InputError) as refused:
        Outer().replaced(speed=1.0)
    assert "count, gain, kind, on, width" in refused.value.remedy


@pytest.mark.parametrize("text", ["a", "=3", " = 3", ""])
def test_texts_that_are_no_settings_are_refused(text):
    with pytest.raises(InputError, match="NAME=VALUE"):
        parsed_settings([text])
