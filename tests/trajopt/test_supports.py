"""Hands on walls and armrests: what a file may say, and what the check sees."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plantigrade import check
from plantigrade.contact.ground import Ground
from plantigrade.contact.limb_sites import limb_site
from plantigrade.contact.plan import PointSupport
from plantigrade.errors import FileError, ParameterError
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.trajopt import make_task, parse_task_file, synthesize

LEAN = """
[task]
name = "lean on a wall"
base = "standing"
nodes_per_second = 10

[parameters]
duration = 1.2

[[support]]
part = "hand_r"
place = [0.5, -0.2, 1.3]
normal = [-1.0, 0.0, 0.0]
friction = 0.6
start = 0.6

[[term]]
type = "rest"
time = 0.0

[[term]]
type = "rest"
time = 1.2
"""


@cache
def person() -> Human:
    return Human.create(1.72, 68.0, joints="42", feet="rigid")


@cache
def leaning() -> Record:
    """A person whose right hand comes to a wall, solved on a coarse mesh."""
    task = parse_task_file(LEAN).task(person())
    made = synthesize(task.body_of(person()), task)
    assert made.success
    return made.record()


def hand(record: Record) -> int:
    return [s.name for s in record.sites].index("hand_r")


def faults(record: Record) -> set[str]:
    return {f.quantity for f in check(record).findings}


def test_the_wall_is_in_the_ground_of_the_record_and_survives_a_file():
    (wall,) = leaning().ground.seats
    assert (wall.normal, wall.friction) == ((-1.0, 0.0, 0.0), 0.6)
    assert Ground.from_dict(leaning().ground.to_dict()) == leaning().ground


def test_the_hand_pushes_into_the_wall_and_stays_in_front_of_it():
    record, i = leaning(), hand(leaning())
    stands = record.contact_planned[:, i]
    assert stands.any() and not stands.all()
    assert np.all(record.contact_force[:, i, 0] <= 1e-6)
    assert np.nanmax(record.contact_point[:, i, 0]) < 0.5 + 1e-3


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda wall: replace(wall, friction=0.01), "friction"),
        (lambda wall: replace(wall, normal=(1.0, 0.0, 0.0)), "adhesion"),
        (lambda wall: replace(wall, position=(0.47, -0.2, 1.3)), "penetration"),
        (lambda wall: replace(wall, position=(0.53, -0.2, 1.3)), "hover"),
    ],
)
def test_the_check_sees_what_a_hand_does_wrong(change, fault):
    record, i = leaning(), hand(leaning())
    assert fault not in faults(record)
    force = record.contact_force.copy()
    force[record.contact_planned[:, i], i] = (-30.0, 5.0, 0.0)
    seats = tuple(map(change, record.ground.seats))
    wrong = replace(record, contact_force=force, ground=replace(record.ground, seats=seats))
    assert fault in faults(wrong)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('part = "hand_r"', 'part = "nose"', r"support\]\] 1 part.*hand_l"),
        ('part = "hand_r"', "part = 3", r"support\]\] 1 part"),
        ("place = [0.5, -0.2, 1.3]", "", "place is missing"),
        ("place = [0.5, -0.2, 1.3]", "place = [0.5, -0.2]", "3 numbers"),
        ("place = [0.5, -0.2, 1.3]", "place = [nan, -0.2, 1.3]", "finite"),
        ("normal = [-1.0, 0.0, 0.0]", "normal = [0.0, 0.0, 0.0]", "zero"),
        ("friction = 0.6", "friction = -1", "friction"),
        ("friction = 0.6", "grip = true", "unknown key 'grip'"),
        ("start = 0.6", "start = 0.6\nstop = 0.5", "before it starts"),
        ("duration = 1.2", "duration = 1000", r"\[parameters\].*duration"),
    ],
)
def test_what_a_support_cannot_be_is_said_with_the_file_and_the_key(old, new, match):
    with pytest.raises(FileError, match=match) as caught:
        parse_task_file(LEAN.replace(old, new), "own.toml")
    assert "own.toml" in str(caught.value)


def test_a_file_written_again_is_the_same():
    file = parse_task_file(LEAN)
    assert parse_task_file(file.toml()) == file


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("start = 0.6", "start = 5.0", "outside the motion"),
        ('base = "standing"', 'base = "hop"', "periodic"),
        (
            "start = 0.6",
            'stop = 0.4\n[[support]]\npart = "hand_r"\nplace = [0.4, -0.2, 1.2]\nstart = 0.6',
            "two supports",
        ),
    ],
)
def test_a_support_that_a_task_cannot_have(old, new, match):
    text = LEAN.replace(old, new)
    if "hop" in new:
        text = text.replace("[parameters]\nduration = 1.2", "").replace("time = 1.2", "time = 0.1")
    with pytest.raises(ParameterError, match=match):
        parse_task_file(text).task(person())


def test_a_normal_has_length_one():
    with pytest.raises(ParameterError, match="length one"):
        PointSupport(limb_site(person(), "hand_r"), (0.5, 0.0, 1.0), 0.0, 1.0, (0.0, 0.0, 2.0))


@pytest.mark.parametrize(("name", "at_start"), [("sit-to-stand", True), ("stand-to-sit", False)])
def test_hands_are_on_armrests_while_seated_and_leave_before_standing(name, at_start):
    task = make_task(name, person(), {"armrests": True})
    rests = [s for s in task.plan.supports if s.site.part == "hand"]
    assert sorted(s.site.name for s in rests) == ["hand_l", "hand_r"]
    right, left = sorted(rests, key=lambda s: s.position[1])
    assert right.position[1] == pytest.approx(-left.position[1], abs=1e-3)
    for rest in rests:
        assert (rest.start < 0.0, rest.stop > task.plan.duration) == (at_start, not at_start)
        body = task.body_of(person())
        end = 0.0 if at_start else task.plan.duration
        q = task.guess(body, task.plan, np.array([end]))
        place = np.array(body.symbolic.positions([rest.site])(q[0])).ravel()
        np.testing.assert_allclose(place, rest.position, atol=1e-6)


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("name", ["sit-to-stand", "stand-to-sit"])
def test_armrests_relieve_the_hips(name):
    human, moments = Human.create(1.72, 68.0), {}
    for armrests in (False, True):
        task = make_task(name, human, {"armrests": armrests})
        record = synthesize(task.body_of(human), task).record()
        assert check(record).ok
        moments[armrests] = np.abs(record.torque("hip_flexion_r")).max()
    assert moments[True] < 0.85 * moments[False]
