"""Joint limits: no coordinate leaves its range, none runs faster than it may."""

import numpy as np
import pytest

from plantigrade.kinematics.state import BodyState
from plantigrade.wbc import JointLimits, TaskOrder, move
from plantigrade.wbc.joint_limits import JointLimitSettings
from plantigrade.wbc.tasks import TimedPosture
from tests.models.presets import PRESETS, person, random_state


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_bounds_never_cross_in_any_state(preset):
    human, rng = person(*preset), np.random.default_rng(0)
    for step in (0.001, 0.005, 0.02):
        limits = JointLimits(human, step)
        for _ in range(20):
            q, v = random_state(human, rng)
            q[7:] += rng.normal(scale=0.1, size=len(q) - 7)  # outside its range too
            low, high = limits.bounds(BodyState(human, q, 30.0 * v))
            assert (low <= high).all()
            assert np.isfinite([low[6:], high[6:]]).all()


@pytest.mark.parametrize("step", [0.001, 0.005, 0.01])
@pytest.mark.parametrize("push", [1.0, -1.0])
def test_a_coordinate_driven_at_its_limit_stops_there(step, push):
    human = person("42", "two-segment")
    state = BodyState(human, human.standing())
    limits = JointLimits(human, step)
    low, high = human.limits
    furthest = np.zeros(len(low))
    for _ in range(round(1.0 / step)):
        lower, upper = limits.bounds(state)
        a = np.zeros(human.model.nv)
        a[6:] = np.clip(push * 500.0, lower, upper)[6:]
        state = state.integrated(a, step)
        out = np.maximum(low - state.qpos[7:], state.qpos[7:] - high)
        furthest = np.maximum(furthest, out)
    assert furthest.max() < 2e-3  # [rad]
    end = high if push > 0 else low
    np.testing.assert_allclose(state.qpos[7:], end, atol=0.02)


def test_no_hinge_runs_faster_than_it_may():
    human = person("42", "two-segment")
    limits = JointLimits(human, 0.005, settings=JointLimitSettings(max_velocity=4.0))
    far = human.standing()
    far[7 + human.hinge("elbow_flex_r")] += 2.0
    far[7 + human.hinge("arm_flex_l")] += 1.0
    order = TaskOrder([], TimedPosture(lambda time: (far, time + 0.05)))
    motion = move(human, order, human.standing(), stop=0.6, limits=limits)
    assert np.abs(motion.qvel[:, 6:]).max() <= 4.0 * (1 + 1e-6)
    assert np.abs(motion.qvel[:, 6:]).max() > 3.9  # it was asked to
    assert motion.qpos[-1, 7 + human.hinge("elbow_flex_r")] == pytest.approx(
        far[7 + human.hinge("elbow_flex_r")], abs=0.05
    )


def test_accelerations_stay_within_theirs():
    human = person("42", "two-segment")
    limits = JointLimits(human, 0.005, settings=JointLimitSettings(max_acceleration=50.0))
    low, high = limits.bounds(BodyState(human, human.standing()))
    assert low.min() >= -50.0 and high.max() <= 50.0


def test_ranges_of_ones_own():
    human = person("42", "two-segment")
    ranges = human.limits.copy()
    k = human.hinge("knee_angle_r")
    ranges[1, k] = 0.3
    bent = human.standing()
    bent[7 + k] = 1.5
    order = TaskOrder([], TimedPosture(lambda time: (bent, time + 0.1)))
    limits = JointLimits(human, 0.005, ranges=ranges)
    motion = move(human, order, human.standing(), stop=1.0, limits=limits)
    assert motion.qpos[:, 7 + k].max() <= 0.3 + 2e-3
    assert motion.qpos[-1, 7 + k] == pytest.approx(0.3, abs=0.02)
