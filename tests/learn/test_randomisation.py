"""Relief and pushes are drawn anew in every episode, within their bounds; landings are rewarded."""

import mujoco
import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError
from plantigrade.learn import ReferenceMotion, Rules
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.landing import Landing, LandingWatch
from plantigrade.learn.parallel_tracking import ParallelTracking
from plantigrade.learn.randomisation import RandomPushes
from plantigrade.learn.reward import LANDING_WEIGHTS, Reward, load_shares
from plantigrade.models import Human
from plantigrade.world import StablePD, World
from plantigrade.world.disturbance import body_index

SMALL = Human.create(1.7, 65.0, "female", "42", "two-segment")


@pytest.fixture(scope="module")
def reference():
    return ReferenceMotion.textbook(SMALL)


def test_every_episode_has_relief_of_its_own(reference):
    """The ground that is known is the one that is touched; its mean is level."""
    tracking = ParallelTracking(Rules(reference=reference, terrain=0.04))
    world, heights = tracking.worlds[0], []
    for seed in (0, 1, 0):
        tracking.start_episodes([0], [0.3], [seed])
        z = np.array(world.ground.field.heights) + world.ground.height
        assert 0.008 <= np.abs(z).max() <= 0.04 and abs(z.mean()) < 0.2 * np.abs(z).max()
        heights.append(z)
        normal = world.contact_force()[:, 2]
        assert normal.max() < 3 * SMALL.mass * GRAVITY  # not started within a bump
        for x, y in np.random.default_rng(seed).uniform((0.5, -1.5), (9.0, 1.5), (20, 2)):
            above, met = np.array([x, y, 3.0]), np.zeros(1, np.int32)
            down = np.array([0.0, 0.0, -1.0])
            gap = mujoco.mj_ray(world.model, world.data, above, down, None, 1, -1, met)
            assert world.model.geom(met[0]).name == "relief"
            # Triangles there, bilinear here.
            assert 3.0 - gap == pytest.approx(float(world.ground.under(above)), abs=2e-3)
    np.testing.assert_array_equal(heights[0], heights[2])
    assert np.abs(heights[0] - heights[1]).max() > 0.005


def test_pushes_come_from_anywhere_and_pass(reference):
    world = World(SMALL, disturbances=(RandomPushes(force=90.0),), rate=60.0, control_rate=30.0,
                  recording=False)  # fmt: skip
    starts, seen = [], []
    for seed in (1, 2, 3, 4, 4):
        world.reset(seed)
        forces = []
        while world.time < 4.0:
            world.advance()
            forces.append(world.data.xfrc_applied[:, :3].copy())
        table = np.array(forces)
        assert not np.delete(table, body_index(SMALL), axis=1).any() and not table[..., 2].any()
        size = np.linalg.norm(table[:, body_index(SMALL)], axis=1)
        acting = np.flatnonzero(size)
        assert size.max() <= 90.0 and size[acting].min() >= 18.0
        gaps = np.split(acting, np.flatnonzero(np.diff(acting) > 1) + 1)
        assert all(len(gap) <= 13 for gap in gaps) and acting[0] >= 8
        starts.append(acting[0])
        seen += [np.arctan2(*table[gap[0], body_index(SMALL), 1::-1]) for gap in gaps]
    assert len(set(starts[:4])) > 2 and starts[3] == starts[4]
    assert np.ptp(seen) > np.pi / 2


def test_the_force_of_a_landing_is_the_grounds(reference):
    """Dropped on the feet: the peak within a decision, which no decision ends at, and the speed."""
    height, duration, qpos = 0.05, 0.3, SMALL.standing()
    hold = StablePD(qpos[7:], stiffness=400.0, damping=40.0)
    qpos[2] += height
    fine, coarse = (
        World(SMALL, rate=150.0, control_rate=rate, recording=False, qpos=qpos)
        for rate in (150.0, 30.0)
    )
    level, levels = 1.0, []
    for _ in range(round(duration * 150.0)):
        fine.advance(hold)
        pressed = fine.contact_force()[:, 2].sum() / (SMALL.mass * GRAVITY)
        level += (1.0 - np.exp(-2.0 * np.pi * 20.0 / 150.0)) * (pressed - level)
        levels.append(level)
    watch, found = LandingWatch([coarse]), []
    watch.start([0])
    coarse.actuators.command(hold, coarse.data)
    for _ in range(round(duration * 30.0)):
        coarse.repeat_command(watch.watchers[0])
        found.append(watch.read())
    ends = [1.0, *levels[4::5]]
    peaks = np.maximum(np.reshape(levels, (-1, 5)).max(axis=1), ends[:-1])
    np.testing.assert_allclose([x.peak[0] for x in found], peaks, rtol=1e-3)
    assert peaks.max() > 2.0 and peaks.max() > 1.05 * max(ends)
    speeds = np.array([x.speed[0] for x in found])
    assert np.count_nonzero(speeds) == 1
    assert speeds.max() == pytest.approx(np.sqrt(2.0 * GRAVITY * height), rel=0.1)


def test_the_load_passes_from_foot_to_foot(reference):
    """In even steps, half a stride apart, while both feet of the reference are down."""
    right = load_shares(reference)
    half = len(right) // 2
    np.testing.assert_allclose(right[half:], 1.0 - right[: half + 1], atol=0.1)
    both = (right > 0.01) & (right < 0.99)
    assert 0.1 < both.mean() < 0.4 and np.abs(np.diff(right)).max() < 0.25


def test_hard_landings_and_turned_feet_are_worth_less(reference):
    world = World(SMALL, recording=False)
    view, reward = (
        BatchState(SMALL, [(world.model, world.data)]),
        Reward(reference, LANDING_WEIGHTS),
    )
    frame, phase = reference.at(np.array([0.25 * reference.period])), np.array([0.25])

    def terms(force: float = 1.0, ankle: float = 0.0, speed: float = 0.0, right: float = 0.0):
        world.data.qpos[: SMALL.model.nq] = frame.qpos[0]
        world.data.qpos[7 + SMALL.hinge("ankle_angle_r")] += ankle
        view.update()
        peak, trough = np.array([max(force, 1.0)]), np.array([min(force, 1.0)])
        loads = np.array([[right, 1.0 - right]])
        return reward.of(view, frame, phase, Landing(peak, trough, loads, np.array([speed])))[1]

    level = terms(1.2, speed=0.2)
    assert level["force"][0] == level["touchdown"][0] == 1.0
    assert level["soles"][0] == pytest.approx(1.0, abs=1e-3)
    assert terms(speed=0.5)["touchdown"][0] == pytest.approx(np.exp(-1.0))
    # A quarter into the stride one foot alone is down: the left one.
    assert terms(right=0.0)["load"][0] == 1.0
    assert terms(right=0.5)["load"][0] == pytest.approx(np.exp(-1.0))
    assert terms(2.25)["force"][0] == pytest.approx(np.exp(-1.0))
    assert terms(0.25)["force"][0] == pytest.approx(np.exp(-0.5))
    # The foot is inclined there, and the axis of the ankle is.
    assert np.exp(-20 * 0.2**2) < terms(1.0, 0.2)["soles"][0] < 0.75
    assert terms(1.0, 0.4)["soles"][0] < 0.2


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"terrain": -0.01}, "terrain must be"),
        ({"terrain": 2.0}, "terrain must be"),
        ({"pushes": -5.0}, "pushes must be"),
        ({"terrain": 0.02, "ground": "bumps:2"}, "cannot be combined"),
    ],
)
def test_disturbances_that_cannot_be_are_refused(reference, options, said):
    with pytest.raises(ParameterError, match=said):
        ParallelTracking(Rules(reference=reference, **options))
