"""Relief and pushes are drawn anew in every episode, within their bounds; landings are rewarded."""

import mujoco
import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError
from plantigrade.learn import Reference, Rules
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.parallel_tracking import ParallelTracking
from plantigrade.learn.randomisation import RandomPushes
from plantigrade.learn.reward import LANDING_WEIGHTS, Reward
from plantigrade.models import Human
from plantigrade.world import World
from plantigrade.world.disturbance import body_index

SMALL = Human.create(1.7, 65.0, "female", "42", "two-segment")


@pytest.fixture(scope="module")
def reference():
    return Reference.textbook(SMALL)


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
    """By momentum what the contacts say, where a decision is one step of the physics."""
    tracking = ParallelTracking(Rules(reference=reference, rate=150.0, control_rate=150.0))
    found = []
    of = tracking._reward.of

    def heard(view, frame, phase, force):
        found.append((force[0], phase[0]))
        return of(view, frame, phase, force)

    tracking._reward.of = heard
    tracking.start_episodes([0], [0.3], [0])
    pressed = []
    for _ in range(30):
        tracking.step(np.zeros((1, len(tracking.action))))
        pressed.append(tracking.worlds[0].contact_force()[:, 2].sum() / (SMALL.mass * GRAVITY))
    force, phase = np.array(found).T
    np.testing.assert_allclose(force, pressed, atol=0.05)
    assert np.ptp(pressed) > 0.3 and (np.diff(phase) > 0).all()


def test_hard_landings_and_turned_feet_are_worth_less(reference):
    world = World(SMALL, recording=False)
    view, reward = (
        BatchState(SMALL, [(world.model, world.data)]),
        Reward(reference, LANDING_WEIGHTS),
    )
    frame, phase = reference.at(np.array([0.25 * reference.period])), np.array([0.25])

    def terms(force: float, ankle: float = 0.0):
        world.data.qpos[: SMALL.model.nq] = frame.qpos[0]
        world.data.qpos[7 + SMALL.hinge("ankle_angle_r")] += ankle
        view.update()
        return reward.of(view, frame, phase, np.array([force]))[1]

    level = terms(1.2)
    assert level["force"][0] == 1.0 and level["soles"][0] == pytest.approx(1.0, abs=1e-3)
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
