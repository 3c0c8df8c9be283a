"""What the tests of all baselines share."""

import pytest

from stereotrack_core.experiments.baselines import particles


@pytest.fixture(autouse=True)
def many_layers(monkeypatch):
    """Layers enough for the few clouds of a test, whose starts are far off."""
    monkeypatch.setattr(particles, "LAYERS", 16)
