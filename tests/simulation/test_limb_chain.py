import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from stereotrack_core.simulation.skeleton import bend_rotation, two_links

coordinate = st.floats(-1, 1, allow_nan=False)
vector = st.tuples(coordinate, coordinate, coordinate).map(np.array)
length = st.floats(0.2, 0.5)


@given(vector, length, length, vector)
def test_links_reach_what_is_within_reach(target, first, second, pole):
    distance = np.linalg.norm(target)
    assume(abs(first - second) * 1.05 + 1e-3 < distance < 0.999 * (first + second))
    assume(np.linalg.norm(np.cross(pole, target)) > 1e-3)
    links = two_links(target, first, second, pole)
    np.testing.assert_allclose(first * links.first + second * links.second, target, atol=1e-9)
    assert np.dot(links.first, pole - target * (pole @ target) / distance**2) >= -1e-9


@given(vector, length, length, vector)
def test_hinge_turns_the_first_link_into_the_second(target, first, second, pole):
    assume(np.linalg.norm(target) > 1e-3)
    links = two_links(target, first, second, pole)
    axis, angle = links.hinge, links.flexion
    turned = np.cos(angle) * links.first + np.sin(angle) * np.cross(axis, links.first)
    np.testing.assert_allclose(turned, links.second, atol=1e-7)


@given(vector, vector)
def test_bend_rotation_turns_one_direction_into_the_other(a, b):
    assume(np.linalg.norm(a) > 1e-2)
    assume(np.linalg.norm(b) > 1e-2)
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    assume(a @ b > -0.999)
    rotation = bend_rotation(a, b)
    np.testing.assert_allclose(rotation @ a, b, atol=1e-9)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)


def test_bend_rotation_of_opposite_directions_is_half_a_turn():
    rotation = bend_rotation(np.array([1.0, 0, 0]), np.array([-1.0, 0, 0]))
    np.testing.assert_allclose(rotation @ [1, 0, 0], [-1, 0, 0], atol=1e-12)
    assert np.linalg.det(rotation) == np.float64(1.0)
