"""A Motion is read by the names of its coordinates."""

import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Motion

HUMAN = Human.create(joints="66")


def a_motion(n=40):
    rng = np.random.default_rng(3)
    names, values = HUMAN.to_coordinates(np.tile(HUMAN.standing(), (n, 1)))
    values = values + np.cumsum(rng.normal(scale=0.02, size=values.shape), axis=0)
    values[:, 2] = np.linspace(0, 3 * np.pi, n)  # one and a half turns about the vertical
    events = tuple(GaitEvent(0.1 * i, "r", "heel_strike") for i in range(5))
    qvel = rng.normal(size=(n, HUMAN.model.nv))
    qpos = HUMAN.from_coordinates(names, values)
    motion = Motion(np.arange(n) / 100, qpos, qvel, HUMAN.joint_names, events=events)
    return motion, dict(zip(names, values.T, strict=True))


def test_every_coordinate_is_read_by_its_name():
    motion, values = a_motion()
    assert motion.coordinates == tuple(values)
    for name, value in values.items():  # angles of the pelvis go on beyond a turn
        np.testing.assert_allclose(motion[name], value, atol=1e-9)


def test_hinges_have_a_place_and_a_velocity():
    motion, _ = a_motion()
    for name in ("knee_angle_r", "hip_flexion_l"):
        i = HUMAN.hinge(name)
        assert motion.hinge(name) == i
        np.testing.assert_array_equal(motion.velocity(name), motion.qvel[:, 6 + i])


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("root", r"and \d+ more"),
        ("knee", "are knee_angle_"),
        ("", r"and \d+ more"),
        ("pelvis", "pelvis_"),
    ],
)
def test_an_unknown_name_is_refused_with_the_known_ones(name, near):
    motion, _ = a_motion()
    for read in (motion.__getitem__, motion.velocity, motion.hinge):
        with pytest.raises(CoordinateNotFound, match=near):
            read(name)


def test_some_frames_keep_their_events():
    motion, _ = a_motion()
    some = motion.frames(slice(10, 30))
    assert some.n_frames == 20 and some.duration == pytest.approx(0.19)
    assert [event.time for event in some.events] == [0.1, 0.2]
    assert motion.frames(slice(0, 0)).events == ()
    assert motion.rate == pytest.approx(100.0)
