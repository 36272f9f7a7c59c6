"""One stride of a walk, whichever way it was walked."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError
from plantigrade.kinematics.leg_inverse import ANKLE, HIP, KNEE
from plantigrade.kinematics.posture import leans
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import BodyState, body_paths
from plantigrade.kinematics.stride import off_the_belt, stride_of
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import lowpass
from plantigrade.spatial.conventions import about_vertical, rotation_matrix, turned
from tests.textbook import walk_record

LEG_COORDINATES = {*HIP, *KNEE, *ANKLE}


@pytest.fixture(scope="module")
def walker():
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    return human, walk_record(human, speed=1.2, rate=60.0, cycles=2).motion


@pytest.mark.parametrize("heading", [0.1, 1.5, np.pi, -2.5])
def test_a_stride_is_the_same_whichever_way_it_was_walked(walker, heading):
    human, walk = walker
    assert leans(human, walk.qpos, "asis_r")[:, 0].mean() > 5.0  # a lean that could be turned aside
    qpos = walk.qpos.copy()
    qpos[:, :3] = qpos[:, :3] @ about_vertical(heading).T
    qpos[:, 3:7] = turned(qpos[:, 3:7], heading)
    expected, found = stride_of(human, walk), stride_of(human, replace(walk, qpos=qpos))
    assert found.cyclic and found.length == pytest.approx(expected.length)
    np.testing.assert_allclose(found.qpos[:, :3], expected.qpos[:, :3], atol=1e-6)
    R, own = (rotation_matrix(stride.qpos[:, 3:7]) for stride in (found, expected))
    np.testing.assert_allclose(R, own, atol=1e-6)


def test_feet_are_raised_to_a_clearance_in_mid_swing_and_stand_as_before():
    """The textbook walk passes the ground at 6 mm; people, over hidden obstacles, at 27 ± 7 mm."""
    human = Human.create(1.5, 48.5, joints="66")
    walk = walk_record(human, speed=1.1, rate=60.0, cycles=2).motion
    stride = stride_of(human, walk)
    raised = stride.cleared(human, 0.03)
    before, after = sole_paths(human, stride.qpos), sole_paths(human, raised.qpos)
    for side in "rl":
        old, new = (p.position[:, p.of(side), 2].min(axis=1) for p in (before, after))
        stands = np.flatnonzero(old < 1e-3)
        np.testing.assert_allclose(new[stands], old[stands], atol=4e-3)
        high = np.flatnonzero(new > 0.03)
        assert 0.3 < len(high) * stride.time[1] / 0.45 < 0.9  # of a swing
        assert old[high].min() < 0.012 and new.max() < 0.06
        feet = [human.body(f"foot_{side}")]
        (_, old), (_, new) = (body_paths(human, x.qpos, feet) for x in (stride, raised))
        np.testing.assert_allclose(new, old, atol=1e-6)  # no foot is tilted
    legs = [j for j, name in enumerate(human.coordinates) if name[:-2] in LEG_COORDINATES]
    rest = np.setdiff1d(np.arange(stride.qpos.shape[1]), [2, *(7 + j for j in legs)])
    np.testing.assert_allclose(raised.qpos[:, rest], stride.qpos[:, rest], atol=1e-6)
    change = np.rad2deg(np.abs(raised.qpos - stride.qpos)[:, [7 + j for j in legs]]).max()
    assert 3.0 < change < 15.0
    again = raised.cleared(human, 0.03)
    np.testing.assert_allclose(again.qpos, raised.qpos, atol=1e-3)
    rates = np.gradient(raised.qpos[:, 7:], stride.time, axis=0)[2:-2]
    np.testing.assert_allclose(raised.qvel[2:-2, 6:], rates, atol=0.4)


def test_a_softened_stride_needs_less_force_and_leaves_the_feet():
    """People's force on both feet peaks at 1.2 to 1.4 body weights, while both are down."""
    human = Human.create(1.5, 48.5, joints="66")
    stride = stride_of(human, walk_record(human, speed=1.1, rate=60.0, cycles=2).motion)
    soft, peaks = stride.softened(human), []
    step = stride.time[1]
    for each in (stride, soft):
        height = np.tile([BodyState(human, q).com[2] for q in each.qpos[:-1]], 3)
        smooth = lowpass(np.arange(len(height)) * step, height, cutoff=20.0)
        force = 1.0 + np.gradient(np.gradient(smooth, step), step) / GRAVITY
        peaks.append(force[len(stride.time) : -len(stride.time)].max())
    assert peaks[0] > 1.4 and 1.1 < peaks[1] < 1.25
    old, new = (sole_paths(human, x.qpos).position for x in (stride, soft))
    np.testing.assert_allclose(new, old, atol=1e-3)
    change = np.rad2deg(np.abs(soft.qpos - stride.qpos)[:, 7:]).max()
    assert 5.0 < change < 15.0
    again = soft.softened(human)
    assert np.ptp(again.qpos[:, 2]) == pytest.approx(np.ptp(soft.qpos[:, 2]), abs=2e-3)


def test_a_motion_that_ends_is_neither_raised_nor_softened(walker):
    human, walk = walker
    whole = replace(stride_of(human, walk), cyclic=False)
    with pytest.raises(ParameterError, match="repeated"):
        whole.cleared(human, 0.03)
    with pytest.raises(ParameterError, match="repeated"):
        whole.softened(human)


def test_a_straight_stride_is_taken_before_a_more_even_one_along_a_bend(walker):
    human, _ = walker
    book = textbook_walk(human, speed=1.2, rate=60.0, cycles=4)
    time, qpos = book.time, book.qpos.copy()
    bends = time[0] + 0.5 * (time[-1] - time[0])
    angle = 0.4 * np.maximum(time - bends, 0.0)
    step = np.diff(qpos[:, :2], axis=0)
    c, s = np.cos(angle[1:]), np.sin(angle[1:])
    way = np.stack([c * step[:, 0] - s * step[:, 1], s * step[:, 0] + c * step[:, 1]], axis=1)
    qpos[1:, :2] = qpos[0, :2] + np.cumsum(way, axis=0)
    for k, turn in enumerate(angle):
        qpos[k : k + 1, 3:7] = turned(qpos[k : k + 1, 3:7], float(turn))
    elbow = 7 + human.coordinates.index("elbow_flex_r")
    qpos[:, elbow] += np.deg2rad(20.0) * np.minimum(time - bends, 0.0)  # moves on the straight part
    rest = np.zeros((len(time), human.model.nv))
    found = stride_of(human, Motion(time, qpos, rest, human.joint_names, events=book.events))
    usual = qpos[time > bends, elbow].mean()
    assert found.cyclic and found.qpos[:, elbow].mean() < usual - np.deg2rad(5.0)


def test_a_stride_is_found_in_a_walk_in_which_no_event_cuts_one(walker):
    human, walk = walker
    expected = stride_of(human, walk)
    period = expected.time[-1]
    last = walk.time[0] + 1.2 * period
    part = walk.time <= last
    cut = replace(walk, time=walk.time[part], qpos=walk.qpos[part], qvel=walk.qvel[part], events=())
    found = stride_of(human, cut)
    assert found.cyclic and found.time[-1] == pytest.approx(period, abs=0.03)
    assert found.length == pytest.approx(expected.length, rel=0.03)
    still = np.repeat(walk.qpos[:1], 60, axis=0)
    time = np.arange(60) / 60.0
    stands = Motion(time, still, np.zeros((60, human.model.nv)), human.joint_names)
    assert not stride_of(human, stands).cyclic


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_step_is_repeated_with_its_mirror_image(walker, heading):
    human, walk = walker
    expected = stride_of(human, walk)
    strikes = sorted(e.time for e in walk.events if e.kind == "heel_strike")
    part = (walk.time >= strikes[0] - 0.05) & (walk.time <= strikes[1] + 0.05)
    qpos = walk.qpos[part].copy()
    qpos[:, :3] = qpos[:, :3] @ about_vertical(heading).T
    qpos[:, 3:7] = turned(qpos[:, 3:7], heading)
    time = walk.time[part]
    events = tuple(e for e in walk.events if time[0] <= e.time <= time[-1])
    found = stride_of(
        human, replace(walk, time=time, qpos=qpos, qvel=walk.qvel[part], events=events)
    )
    assert found.cyclic and found.time[-1] == pytest.approx(expected.time[-1], abs=0.03)
    assert found.length == pytest.approx(expected.length, rel=0.03)
    names = human.coordinates
    share, phase = found.time / found.time[-1], np.arange(50) / 50
    for name in ("knee_angle", "hip_flexion"):
        left, right = (found.qpos[:, 7 + names.index(f"{name}_{side}")] for side in "lr")
        later = np.interp((phase + 0.5) % 1.0, share, right)
        np.testing.assert_allclose(np.interp(phase, share, left), later, atol=0.005)


def test_a_stride_can_begin_where_one_foot_passes_the_other(walker):
    human, walk = walker
    stride = stride_of(human, walk)
    found = stride.from_single_support(human)
    assert found.cyclic and found.length == stride.length
    feet = [human.body(f"foot_{side}") for side in "rl"]
    place = body_paths(human, found.qpos, feet)[0]
    steps = np.abs(place[:, 0, 0] - place[:, 1, 0])
    assert steps[0] < 0.1 * steps.max()
    np.testing.assert_allclose(found.qpos[-1, 1:], found.qpos[0, 1:], atol=1e-9)
    assert found.qpos[0, 0] == 0.0 and found.qpos[-1, 0] == pytest.approx(stride.length)
    assert (
        np.abs(np.diff(found.qpos, axis=0)).max() < 1.5 * np.abs(np.diff(stride.qpos, axis=0)).max()
    )
    still = replace(stride, cyclic=False)
    assert still.from_single_support(human) is still


def test_a_walk_on_a_treadmill_gets_on_over_the_ground():
    human = Human.create(1.7, 65.0, "female", "42", "two-segment")
    record = walk_record(human, speed=1.2, rate=60.0, cycles=3)
    time, qpos = record.motion.time, record.motion.qpos.copy()
    qvel = np.zeros_like(record.motion.qvel)
    qvel[:, :3] = np.gradient(qpos[:, :3], time, axis=0)
    over = replace(record.motion, qvel=qvel)
    assert off_the_belt(human, over) is over
    qpos[:, 0] -= 1.2 * time
    slower = qvel - 1.2 * np.eye(qvel.shape[1])[0]
    on = off_the_belt(human, replace(over, qpos=qpos, qvel=slower))
    np.testing.assert_allclose(on.qpos, over.qpos, atol=0.03)
    np.testing.assert_allclose(on.qvel[:, 0], over.qvel[:, 0], atol=0.1)
