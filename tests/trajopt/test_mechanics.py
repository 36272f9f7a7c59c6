"""Simple mechanics rules out jumps, falls, crouches, rests that nobody gets to in time."""

import numpy as np
import pytest

from experiments.random_requests import random_request
from plantigrade.constants import GRAVITY
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt import make_task
from plantigrade.trajopt.guess.postures import standing_feet, standing_stances
from plantigrade.trajopt.tasks.mechanics import missing_support, push_power, quickest


def person() -> Human:
    return Human.create(1.75, 72.0, joints="43", feet="two-segment")


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("jump", {"jump_height": 1.2}, r"takes 126 W/kg on average, nobody .* at most 0\.57"),
        ("jump", {"push": 0.4}, r"countermovement by 0.26 m in 0.24 s is too soon.* 0.27 s"),
        ("take-off", {"strength": 0.1}, r"takes 14 % of the strength .* 10 % may be used"),
        ("squat", {"depth": 0.5, "duration": 0.6}, "a squat by 0.50 m in 0.30 s is too soon"),
        ("sit-to-stand", {"chair_height": 0.3, "duration": 0.5}, "to rise by 0.42 m in 0.33 s"),
        ("stand-to-sit", {"duration": 0.5}, "push 20 cm outside of the feet"),
        ("side-step", {"distance": 0.45, "duration": 0.8}, "push 11 cm outside of the feet"),
    ],
)
def test_an_impossible_motion_is_refused_with_the_limit_it_exceeds(name, options, words):
    with pytest.raises(ParameterError, match=words):
        make_task(name, person(), options)


def test_small_children_do_not_walk_as_fast_as_adults():
    child = Human.create(0.75, 9.0)
    with pytest.raises(ParameterError, match=r"Froude number 1\.\d\d: .* at most 1.9\d m/s"):
        make_task("walk", child, {"speed": 2.2, "periodic": True})


def test_what_healthy_adults_do_is_not_refused():
    """Neither random requests nor jumps to 40 cm of the smallest, nor quick and low chairs."""
    for seed in range(48):
        asked = random_request(seed)
        make_task(asked.task, asked.human, asked.options)
    small = Human.create(1.45, 45.0, "female")
    for name, options in (
        ("jump", {"jump_height": 0.4}),
        ("sit-to-stand", {"chair_height": 0.25, "duration": 1.2}),
        ("sit-to-stand", {"seat_off": 0.1}),
        ("walk", {"speed": 2.2}),
        ("walk", {"speed": 0.3, "step_length": 0.8}),
    ):
        make_task(name, small, options)


def test_a_seat_may_be_left_late():
    task = make_task("sit-to-stand", person(), {"seat_off": 0.8})
    assert np.all(np.diff(task.guess.times) > 0)


def test_power_of_a_push_is_its_work_over_its_time():
    h, s = 0.35, 0.42
    v = np.sqrt(2 * GRAVITY * h)
    work, time = GRAVITY * (h + s), s / (v / 2)  # with a constant force, per mass
    assert push_power(h, s) == pytest.approx(work / time)


def test_the_quickest_fall_is_freely_and_then_against_the_legs():
    d, t = 0.3, quickest(0.3)
    free = np.sqrt(2 * d * 3 / 4 / GRAVITY)  # three quarters of the way, then three times gravity
    assert t == pytest.approx(free + GRAVITY * free / (3 * GRAVITY))


def test_a_sway_over_standing_feet_needs_support_that_grows_with_speed():
    """Half of the way with the ground at one edge, half at the other: x'' = ± a over T / 2 each."""
    human = person()
    z = 1.0
    feet = standing_feet(human)
    middle = np.mean([f.position[:2] for f in feet.values()], axis=0)

    def missing(way: float, duration: float) -> float:
        plan = ContactPlan(duration, standing_stances(feet, duration))
        start = (float(middle[0]), float(middle[1] - way / 2), z)
        return missing_support(human, plan, (start, (start[0], start[1] + way, z)))

    assert missing(0.1, 1.5) == 0.0
    short = [missing(0.3, t) for t in (1.0, 0.6, 0.4)]
    assert short[0] < short[1] < short[2]
    # so short a time that the pendulum hardly falls: acceleration = rate² (x - pressure)
    edge = max(abs(f.position[1]) for f in feet.values()) + human.dimensions.foot_width / 2
    duration, way = 0.2, 0.3
    assert missing(way, duration) == pytest.approx(
        4 * way / duration**2 * z / GRAVITY - edge, rel=0.1
    )
