"""Faults that are planted into a rendered recording, one at a time, are named."""

import pytest

from tests.doctor.planted.faults import faults
from tests.doctor.planted.scoring import rendered, said_of_fault, said_of_sound, table

pytestmark = pytest.mark.slow

DEPTH, OTHER = 2, 3
"""Three depth cameras, and a recording of another person whose reference is taken for a wrong
one."""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    root = tmp_path_factory.mktemp("planted")
    return root, rendered(root, DEPTH), rendered(root, OTHER)


def test_most_faults_are_named_with_their_cause(folders):
    root, sound, other = folders
    said = [said_of_fault(sound, other, one.name, root, DEPTH) for one in faults(other)]
    known = [one for one in said if one is not None]
    named = sum(one.named for one in known) / len(known)
    right = sum(one.right for one in known) / len(known)
    assert len(known) >= 15, table(known)
    assert named >= 0.85, table(known)
    assert right >= 0.75, table(known)


def test_the_sound_recording_has_no_errors(folders):
    root, sound, _ = folders
    outcome = said_of_sound(sound, root)
    assert not outcome.findings, outcome.findings
