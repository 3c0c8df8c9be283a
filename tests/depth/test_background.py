import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stereotrack_core.depth.background import (
    averaged,
    empty_scene_model,
    percentile_model,
)

disparity = st.one_of(st.just(float("nan")), st.floats(0.5, 60.0, width=32))
images = st.lists(arrays(np.float32, (3, 4), elements=disparity), min_size=1, max_size=12)


def oracle_average(sequence, rate, validity_rate):
    """The recursions of 3.1.1, one pixel after the other, in double precision."""
    shape = sequence[0].shape
    d_model, g_model = np.zeros(shape), np.zeros(shape)
    for k, image in enumerate(sequence):
        for v in range(shape[0]):
            for u in range(shape[1]):
                d = float(image[v, u])
                valid = d == d
                if valid and (k == 0 or g_model[v, u] == 0):
                    d_model[v, u] = d
                elif valid:
                    d_model[v, u] = (1 - rate) * d_model[v, u] + rate * d
                if k == 0:
                    g_model[v, u] = float(valid)
                else:
                    g_model[v, u] = (1 - validity_rate) * g_model[v, u] + validity_rate * valid
    return d_model, g_model


@given(images, st.floats(0.01, 1.0), st.floats(0.01, 0.99))
@settings(max_examples=60, deadline=None)
def test_averages_agree_with_the_equations_pixel_by_pixel(sequence, rate, validity_rate):
    model = None
    for image in sequence:
        model = averaged(model, image, rate, validity_rate)
    d_model, g_model = oracle_average(sequence, rate, validity_rate)
    assert np.allclose(model.frequency, g_model, atol=1e-5)
    seen = g_model > 0
    assert np.allclose(model.disparity[seen], d_model[seen], rtol=1e-4)


@given(images, arrays(np.float32, (3, 4), elements=disparity), st.floats(0.0, 5.0))
@settings(max_examples=60, deadline=None)
def test_foreground_agrees_with_equation_3_3(sequence, image, threshold):
    model = percentile_model(sequence, 20.0)
    got = image > model.limit(threshold)
    for v in range(3):
        for u in range(4):
            d, d_model = image[v, u], np.float32(model.disparity[v, u])
            valid, known = d == d, model.frequency[v, u] > 0.5
            expected = valid and (not known or d > d_model + np.float32(threshold))
            assert got[v, u] == expected


@given(images, st.floats(0.0, 100.0))
@settings(max_examples=60, deadline=None)
def test_the_percentile_is_taken_among_valid_disparities(sequence, percentile):
    model = percentile_model(sequence, percentile)
    for v in range(3):
        for u in range(4):
            values = [i[v, u] for i in sequence if i[v, u] == i[v, u]]
            assert model.frequency[v, u] == pytest.approx(len(values) / len(sequence))
            if values:
                expected = np.percentile(values, percentile, method="lower")
                neighbours = sorted(values)
                assert model.disparity[v, u] in neighbours
                assert model.disparity[v, u] <= np.float32(expected) + 1e-5 or percentile == 100


def test_a_resting_person_melts_into_the_average_but_not_into_the_percentile():
    wall, person = np.full((2, 2), 5.0, np.float32), np.full((2, 2), 15.0, np.float32)
    sequence = [wall] * 30 + [person] * 60
    model = None
    for image in sequence:
        model = averaged(model, image, 0.05, 0.05)
    assert not (person > model.limit(1.0)).any()
    assert (person > percentile_model(sequence, 20.0).limit(1.0)).all()


def test_the_empty_scene_is_the_model_at_once():
    scene = np.array([[4.0, np.nan]], np.float32)
    limit = empty_scene_model(scene).limit(1.0)
    assert (np.array([[4.9, 0.5]], np.float32) > limit).tolist() == [[False, True]]
    assert (np.array([[5.1, np.nan]], np.float32) > limit).tolist() == [[True, False]]


def test_a_stack_of_large_images_is_never_copied_whole():
    rng = np.random.default_rng(0)
    images = [rng.uniform(1.0, 60.0, (480, 320)).astype(np.float32) for _ in range(40)]
    tracemalloc.start()
    model = percentile_model(images, 20.0)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 0.5 * sum(image.nbytes for image in images)
    np.testing.assert_array_equal(model.disparity, np.sort(np.stack(images), axis=0)[7])
    np.testing.assert_array_equal(model.frequency, 1.0)
