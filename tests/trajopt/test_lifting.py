"""Lifting a box: its way, its weight on the hands, and the motion."""

from functools import cache

import numpy as np
import pytest

from plantigrade import check
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt import MotionTask, make_task, synthesize
from plantigrade.trajopt.terms.carrying import (
    BehindTrajectory,
    Carried,
    CarryingPath,
    FollowTrajectory,
)


@cache
def person() -> Human:
    return Human.create(1.72, 68.0, joints="42", feet="rigid")


@cache
def task(mass: float = 12.0) -> MotionTask:
    return make_task("lift", person(), {"box_mass": mass})


@cache
def way() -> CarryingPath:
    return next(t.way for t in task().terms if isinstance(t, FollowTrajectory))


def test_a_way_rests_at_both_ends_and_its_derivatives_are_right():
    t = np.linspace(way().start, way().stop, 2001)
    step = t[1] - t[0]
    place, speed, acceleration = (way().at(t, order) for order in (0, 1, 2))
    np.testing.assert_allclose(np.gradient(place, step, axis=0)[1:-1], speed[1:-1], atol=1e-4)
    inner = np.gradient(speed, step, axis=0)[2:-2]
    np.testing.assert_allclose(inner, acceleration[2:-2], atol=0.02)
    np.testing.assert_allclose(place[[0, -1]], np.array(way().places)[[0, -1]])
    np.testing.assert_allclose(speed[[0, -1]], 0.0, atol=1e-9)


def test_the_box_is_over_the_table_before_it_goes_forward():
    t = np.linspace(way().start, way().stop, 500)
    place = way().at(t)
    forward = place[:, 0] > place[0, 0] + 1e-6
    assert place[forward, 2].min() >= place[-1, 2]


def test_both_hands_bear_weight_and_inertia_and_nothing_before_and_after():
    plan = task().plan
    t = np.array([0.0, way().start + 0.1, way().stop - 0.1, plan.duration])
    force = sum(w.values(t, plan)[:, :3] for w in task().terms if isinstance(w, Carried))
    inertia = way().at(t, 2)
    np.testing.assert_allclose(force[[0, -1]], 0.0, atol=1e-9)
    expected = -12.0 * (inertia + [0.0, 0.0, person().gravity])
    np.testing.assert_allclose(force[1:3], expected[1:3], atol=1e-9)


def test_knees_pelvis_trunk_and_head_are_kept_behind_the_box():
    body = task().body_of(person())
    kept = [t for t in task().terms if isinstance(t, BehindTrajectory)]
    assert len(kept) == 6
    for term in kept:
        (condition,) = term.conditions(body, task().plan)
        assert np.isfinite(condition.upper).all()


@pytest.mark.parametrize(
    ("parameters", "match"),
    [({"box_mass": 50.0}, "box_mass"), ({"table_height": 3.0}, "table"), ({"duration": 1}, "dur")],
)
def test_what_is_not_lifted(parameters, match):
    with pytest.raises(ParameterError, match=match):
        make_task("lift", person(), parameters)


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("mass", [0.0, 20.0])
def test_a_box_is_lifted(mass):
    human = Human.create(1.74, 71.0)
    lifting = make_task("lift", human, {"box_mass": mass})
    record = synthesize(lifting.body_of(human), lifting).record()
    assert check(record).ok
    assert np.rad2deg(record.motion["lumbar_extension"].min()) > -45.0  # people: -24 ± 7
    hands = [i for i, s in enumerate(record.sites) if s.name.startswith("push")]
    t = record.motion.time
    middle = int(np.argmin(np.abs(t - (way().start + 0.3))))
    force = record.contact_force[middle, hands].sum(axis=0)
    own = next(x.way for x in lifting.terms if isinstance(x, FollowTrajectory))
    expected = -mass * (own.at(t[[middle]], 2)[0] + [0.0, 0.0, human.gravity])
    np.testing.assert_allclose(force, expected, atol=1e-6)


def test_the_box_that_is_drawn_is_the_one_that_moves_and_ends_on_the_table():
    lifting, times = task(), np.linspace(0.0, 4.0, 41)
    signals = lifting.object_signals(times)
    box, table = signals["things.place"].transpose(1, 0, 2)
    np.testing.assert_allclose(np.diff(box[:, :3], axis=0), np.diff(way().at(times), axis=0))
    (_, _, half), (depth, _, thickness) = signals["things.size"]
    assert box[0, 2] == pytest.approx(half)
    assert box[-1, 2] - half == pytest.approx(table[-1, 2] + thickness)
    assert table[0, 0] - depth < box[-1, 0]  # it does not tip over the edge
