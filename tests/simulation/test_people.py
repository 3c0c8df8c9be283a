import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.simulation.people import PEOPLE, person_named


def test_four_people_have_the_statures_of_the_four_subjects():
    assert {name: person.stature for name, person in PEOPLE.items()} == {
        "P1": 1.89,
        "P2": 1.75,
        "P3": 1.99,
        "P4": 1.68,
    }


def test_nobody_is_a_scaled_copy_of_somebody_else():
    shares = {round(person.upper_arm / person.stature, 4) for person in PEOPLE.values()}
    assert len(shares) == len(PEOPLE)


@pytest.mark.parametrize("person", PEOPLE.values(), ids=PEOPLE)
def test_lengths_stay_near_those_of_the_average_person(person):
    assert person.upper_arm / person.stature == pytest.approx(0.168, rel=0.07)
    assert person.torso_length / person.stature == pytest.approx(0.282, rel=0.07)


def test_subject_holds_every_length():
    subject = PEOPLE["P3"].subject()
    assert subject.name == "P3"
    assert subject.forearm_length == PEOPLE["P3"].forearm
    assert None not in vars(subject).values()


def test_unknown_person_is_named_with_what_would_be_right():
    with pytest.raises(InputError, match=r"P9.*P1, P2, P3, P4"):
        person_named("P9")
