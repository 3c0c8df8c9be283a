"""What parameters do: rows of name, two values, number, relation, expected and within."""


def check(name, low, high, number, relation, expected, within):
    """Compare a number, which takes parameters by name, between two values of a parameter."""
    one, two = (float(number(**{name: value})) for value in (low, high))
    found = two / one if relation == "ratio" else two - one
    found /= high - low if relation == "slope" else 1.0
    assert abs(found - expected) <= within, f"{one:g} and {two:g}: {relation} {found:g}"
