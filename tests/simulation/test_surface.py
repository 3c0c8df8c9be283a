from collections import namedtuple

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.skeleton import rest_joints
from stereotrack_core.simulation.surface import rest_surface

Surface = namedtuple("Surface", "vertices normals triangles")


@pytest.fixture(scope="module", params=list(PEOPLE))
def person(request):
    return PEOPLE[request.param]


@pytest.fixture(scope="module")
def surface(person):
    return Surface(*rest_surface(person))


def test_surface_is_closed_and_in_one_piece(surface):
    edges = np.concatenate([surface.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    directed, counts = np.unique(edges, axis=0, return_counts=True)
    assert counts.max() == 1
    backwards = {tuple(edge) for edge in directed[:, ::-1]}
    assert backwards == {tuple(edge) for edge in directed}
    n = len(surface.vertices)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (n, n))
    assert connected_components(graph)[0] == 1


def test_person_is_as_tall_as_said_and_stands_on_the_floor(person, surface):
    assert surface.vertices[:, 2].max() == pytest.approx(person.stature, abs=0.015)
    assert surface.vertices[:, 2].min() == pytest.approx(0.0, abs=0.015)
    reach = rest_joints(person)[:, 0].max() + person.hand
    assert surface.vertices[:, 0].max() == pytest.approx(reach, abs=0.02)
