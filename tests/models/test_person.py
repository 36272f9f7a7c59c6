"""Persons, Humans and their descriptions."""

import json

import pytest

from plantigrade.errors import ParameterError
from plantigrade.models import Human, Person
from tests.models.presets import PRESETS


@pytest.mark.parametrize(("joints", "feet"), PRESETS)
def test_a_human_round_trips_through_its_description(joints, feet):
    human = Human.create(1.63, 58.5, "female", joints, feet, lengths={"thigh": 0.41})
    spheres = [name for name, _, _ in human.contact_points]
    on_soles = human.with_soles({spheres[0]: -0.012, spheres[-1]: 0.004})
    twice = on_soles.with_soles({spheres[0]: 0.002})
    for one in (human, on_soles, twice):
        back = Human.from_dict(json.loads(json.dumps(one.to_dict())))
        assert back.xml == one.xml
        assert back.to_dict() == one.to_dict()


def test_a_new_mass_keeps_lengths_and_soles():
    human = Human.create(1.63, 58.5, "female", lengths={"thigh": 0.41})
    human = human.with_soles({human.contact_points[0][0]: -0.01})
    heavier = human.with_mass(70.0)
    assert heavier.to_dict() == {**human.to_dict(), "mass": 70.0}
    assert heavier.model.body_mass.sum() == pytest.approx(70.0, rel=1e-12)


def test_limits_of_total_displacements():
    human = Human.create()
    name = human.contact_points[0][0]
    with pytest.raises(ParameterError, match=r"0\.12 m.*±0\.1 m"):  # the sum counts
        human.with_soles({name: 0.06}).with_soles({name: 0.06})


@pytest.mark.parametrize(
    "wrong",
    [
        {"height": "tall"},
        {"height": 10**400},
        {"mass": None},
        {"soles": 3},
        {"soles": {"contact_nose": 0.01}},
        {"soles": {"contact_nose": "thick"}},
        {"lengths": {"tail": 0.3}},
        {"joints": "44"},
        {"colour": "red"},
    ],
)
def test_an_invalid_description_raises(wrong):
    with pytest.raises(ParameterError):
        Human.from_dict({**Human.create().to_dict(), **wrong})


def test_unknown_properties_keep_their_defaults():
    assert Person().human().to_dict() == Human.create().to_dict()
    person = Person(height=1.5, sex="female", feet="multi-segment")
    assert person.known == {"height": 1.5, "sex": "female", "feet": "multi-segment"}
    human = person.human()
    assert (human.height, human.sex, human.feet) == (1.5, "female", "multi-segment")
    assert human.mass == Human.create().mass


@pytest.mark.parametrize("wrong", [{"height": 0.0}, {"mass": 1000.0}, {"height": float("nan")}])
def test_values_of_the_wrong_type_raise(wrong):
    with pytest.raises(ParameterError):
        Person(**wrong).human()
