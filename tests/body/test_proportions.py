"""Lengths of a person."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.proportions import AVERAGE, Proportions, proportions_of
from stereotrack_core.recording.description import Subject


def test_without_a_subject_lengths_are_average():
    assert proportions_of(None) == proportions_of(Subject()) == AVERAGE


def test_measured_lengths_are_kept_and_missing_ones_scaled():
    known = {"torso_length": 1.1 * AVERAGE.torso_length, "hand_length": 1.1 * AVERAGE.hand_length}
    filled = proportions_of(Subject(name="P1", **known))
    for field in dataclasses.fields(Proportions):
        assert getattr(filled, field.name) == pytest.approx(1.1 * getattr(AVERAGE, field.name))
    assert filled.torso_length == known["torso_length"]
    assert filled.scale == pytest.approx(1.1)


def test_all_measured_lengths_are_taken_as_they_are():
    lengths = {f.name: 0.1 + 0.01 * i for i, f in enumerate(dataclasses.fields(Proportions))}
    assert dataclasses.asdict(proportions_of(Subject(name="", **lengths))) == lengths


def test_average_proportions_can_be_asked_for():
    tall = Proportions(**{k: 1.2 * v for k, v in dataclasses.asdict(AVERAGE).items()})
    average = body_model(tall, BodyParameters(proportions="average"))
    np.testing.assert_array_equal(average.skeleton.lengths, body_model(AVERAGE).skeleton.lengths)
    individual = body_model(tall, BodyParameters(proportions="individual"))
    np.testing.assert_allclose(individual.skeleton.lengths, 1.2 * average.skeleton.lengths)
