"""Bodies for the tests."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.proportions import AVERAGE


@pytest.fixture
def rng():
    return np.random.default_rng(2005)


@pytest.fixture(scope="session")
def body():
    """Average person with legs."""
    return body_model(AVERAGE)


@pytest.fixture(scope="session")
def legless():
    """The thesis's eleven cones."""
    return body_model(AVERAGE, BodyParameters(legs=False, girdle=False))
