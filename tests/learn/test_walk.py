"""The environment is what Gymnasium and its learners expect, and obeys paper and mechanics."""

import sys
import warnings
from dataclasses import replace

import gymnasium
import mujoco
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import plantigrade.learn as learn
from plantigrade.contact.relief import Bump
from plantigrade.errors import MissingExtra, ParameterError
from plantigrade.learn import PAPER_GAINS, ReferenceMotion, WalkEnv, Walks
from plantigrade.learn.action import Action
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.reference import headings
from plantigrade.learn.reward import LEAN_WEIGHTS, Reward
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record

SMALL = Human.create(1.7, 65.0, "female", "42", "two-segment")


@pytest.fixture(scope="module")
def reference():
    return ReferenceMotion.textbook(SMALL)


@pytest.fixture(scope="module")
def lean(reference):
    return WalkEnv(reference)


@pytest.fixture(scope="module")
def paper(reference):
    return WalkEnv(reference, form="paper")


def moved(env: WalkEnv, steps: int, seed: int = 0, size: float = 0.2) -> list[np.ndarray]:
    """Return what is seen under a random policy."""
    env.reset(seed=seed)
    env.action_space.seed(seed)
    return [env.step(size * env.action_space.sample())[0] for _ in range(steps)]


@pytest.mark.parametrize("form", ["lean", "paper"])
def test_gymnasium_finds_no_fault(reference, form):
    env = gymnasium.make(learn.WALK, reference=reference, form=form, duration=0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*infinity.*")  # bounds of what is seen
        check_env(env.unwrapped)
    box = env.action_space
    assert isinstance(box, gymnasium.spaces.Box)  # what stable-baselines3 asks for
    assert box.dtype == np.float32 and (box.low == -1.0).all() and (box.high == 1.0).all()
    seen, _ = env.reset(seed=1)
    assert seen.dtype == np.float32 and seen in env.observation_space


def test_a_seed_decides_all(lean):
    first, again, other = (moved(lean, 4, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first[0], other[0])
    lean.reset(seed=3)
    assert lean.reset()[1]["phase"] != lean.reset(seed=3)[1]["phase"]


def standing(human: Human) -> Motion:
    """Return one second of standing."""
    time = np.linspace(0.0, 1.0, 5)
    rest = np.zeros((5, human.model.nv))
    return Motion(time, np.tile(human.standing(), (5, 1)), rest, human.joint_names)


def test_the_state_and_action_have_the_sizes_of_the_papers():
    """66 coordinates: 60 displacements, and gains of the five joints of each foot."""
    human = Human.create(1.50, 48.5, joints="66")
    walk = WalkEnv(Record(human, standing(human)), form="paper")
    bodies = len(walk.tracking.reference.human.body_names)
    assert (len(walk.tracking.action.displaced), len(walk.tracking.action.joints)) == (60, 10)
    assert walk.observation_space.shape == (13 * bodies + 1,) and bodies == 21
    slim = WalkEnv(walk.tracking.reference, gains=True)
    assert (len(slim.tracking.action.displaced), len(slim.tracking.action.joints)) == (36, 10)
    assert slim.observation_space.shape == (15 * bodies + 9,)


def test_a_reference_goes_on_for_ever_along_x(reference):
    period, stride = reference.period, reference.stride
    nq = SMALL.model.nq
    for time in (0.0, 0.31 * period, 0.99 * period):
        now, later = reference.at(time), reference.at(time + 3 * period)
        assert later.qpos[0] - now.qpos[0] == pytest.approx(3 * stride)
        np.testing.assert_allclose(later.qpos[1:], now.qpos[1:], atol=1e-9)
        np.testing.assert_allclose(later.com - now.com, [3 * stride, 0, 0], atol=1e-9)
        ahead, rate = reference.at(time + 1e-3), np.zeros(SMALL.model.nv)
        mujoco.mj_differentiatePos(SMALL.model, rate, 1e-3, now.qpos, ahead.qpos)
        np.testing.assert_allclose(rate, now.qvel, atol=0.3)  # linear between rows of the table
    assert stride / period == pytest.approx(1.17, abs=0.1) and reference.table.shape[1] > nq
    assert reference.phase(2.25 * period) == pytest.approx(0.25)


def test_a_walk_on_a_belt_gets_the_way_of_the_belt(reference):
    time = np.arange(0.0, 2.5 * reference.period, 0.01)
    rows = [reference.at(float(t)) for t in time]
    qpos, qvel = np.array([r.qpos for r in rows]), np.array([r.qvel for r in rows])
    qpos[:, 0] -= reference.stride / reference.period * time
    keep = time < reference.period + 1e-9
    belt = Motion(time, qpos, qvel, SMALL.joint_names)
    found = ReferenceMotion.of_motion(SMALL, belt.frames(keep))
    speed = found.stride / found.period
    assert found.cyclic and speed == pytest.approx(reference.stride / reference.period, rel=0.06)


def test_what_is_no_walk_ends(reference):
    time = np.linspace(0.0, 0.4, 13)
    rows = [reference.at(0.1 + float(t)) for t in time]
    part = Motion(
        time, np.array([r.qpos for r in rows]), np.array([r.qvel for r in rows]), SMALL.joint_names
    )
    env = WalkEnv(Record(SMALL, part), start=0.8)
    assert not env.tracking.reference.cyclic
    env.reset(seed=0)
    ends = [env.step(np.zeros(len(env.tracking.action)))[2:4] for _ in range(3)]
    assert ends[0] == (False, False) and ends[2] == (False, True)


def test_gains_are_the_papers(reference):
    """Eqs. 8 and 9 as printed: 1 to 160000 N m/rad, 6 to 253 N m s/rad."""
    action = Action(SMALL, PAPER_GAINS, all_joints=True, variable=True, reach=1.0, feed_rates=False)
    assert action.joints == ("foot_l", "toes_l", "foot_r", "toes_r")
    hinge = SMALL.hinge("mtp_angle_r")
    for alpha, stiffness, damping in ((-1, 1.0, 6.3), (0, 400.0, 40.0), (1, 160000.0, 253.0)):
        asked = np.zeros((1, len(action)))
        asked[0, -1] = alpha
        found = [each[0] for each in action.gains_of(asked)]
        assert (found[0][hinge], found[1][hinge]) == pytest.approx((stiffness, damping), rel=0.01)
        assert found[0][SMALL.hinge("mtp_angle_l")] == pytest.approx(400.0)
    asked = np.zeros((1, len(action)))
    asked[0, SMALL.hinge("knee_angle_l")] = 0.5
    frame = reference.at(np.array([0.2]))
    off = (action.targets(asked, frame) - frame.qpos[:, 7:])[0]
    assert off[SMALL.hinge("knee_angle_l")] == pytest.approx(0.5) and np.count_nonzero(off) == 1


def test_bodies_are_seen_as_mujoco_has_them(paper):
    moved(paper, 3)
    seen = paper.step(np.zeros(len(paper.tracking.action)))[0].astype(float)
    model, data, n = paper.world.model, paper.world.data, len(SMALL.body_names)
    turn = headings(data.qpos[None, 3:7])[0]
    place, velocity, quat, spin = np.split(seen[:-1], [3 * n, 6 * n, 10 * n])
    quat, six = quat.reshape(n, 4), np.zeros(6)
    for i in (0, 4, n - 1):
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, i + 1, six, 0)
        np.testing.assert_allclose(velocity[3 * i : 3 * i + 3], six[3:] @ turn, atol=1e-4)
        np.testing.assert_allclose(spin[3 * i : 3 * i + 3], six[:3] @ turn, atol=1e-4)
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, quat[i])
        np.testing.assert_allclose(axes.reshape(3, 3), turn.T @ data.xmat[i + 1].reshape(3, 3),
                                   atol=1e-5)  # fmt: skip
        expected = (data.xpos[i + 1] - data.xpos[1]) @ turn
        expected[2] += data.xpos[1, 2] * (i == 0)
        np.testing.assert_allclose(place[3 * i : 3 * i + 3], expected, atol=1e-5)
    assert (quat[:, 0] >= 0).all() and seen[-1] == pytest.approx(paper.phase, abs=1e-6)


def test_the_reward_is_one_on_the_reference_and_less_off_it(lean):
    lean.reset(seed=0, options={"phase": 0.5})
    *_, info = lean.step(np.zeros(len(lean.tracking.action)))
    terms = {"pose", "velocity", "com", "ends"}
    assert terms < set(info)
    frame = lean.tracking.reference.at(lean.tracking.time)
    data = lean.world.data
    view = BatchState(SMALL, [(lean.world.model, data)])
    data.qpos[: SMALL.model.nq], data.qvel[: SMALL.model.nv] = frame.qpos[0], frame.qvel[0]
    view.update()
    reward, phase = Reward(lean.tracking.reference, LEAN_WEIGHTS), lean.tracking.phase
    assert reward.of(view, frame, phase)[0] == pytest.approx([1.0], abs=1e-4)
    view.angles[0, SMALL.hinge("knee_angle_r")] += 0.5
    _, terms = reward.of(view, frame, phase)
    assert terms["pose"] == pytest.approx([np.exp(-2 * 0.25)]) and terms["com"] > 0.999


def test_an_episode_ends_at_a_fall_at_its_length_and_where_it_diverges(reference):
    env = WalkEnv(reference, start=0.0, duration=0.1)
    env.reset(seed=0)
    still = np.zeros(len(env.tracking.action))
    assert [env.step(still)[2:4] for _ in range(3)] == [(False, False)] * 2 + [(False, True)]
    tall = WalkEnv(reference, start=0.0)
    tall.reset(seed=0)
    for _ in range(90):
        *_, terminated, truncated, info = tall.step(still)
        if terminated:
            break
    assert terminated and not truncated and info["end"] in ("fell", "lost")
    assert 0.2 < tall.world.time < 3.0
    tall.reset(seed=0)
    tall.world.data.qvel[:] = 1e5
    seen, reward, terminated, _, info = tall.step(still)
    assert terminated and info["end"] == "diverged" and reward == 0.0 and np.isfinite(seen).all()


def test_an_episode_can_be_looked_at_and_starts_on_rough_ground(reference):
    env = WalkEnv(reference, ground="bumps:3", recording=True, start=0.2)
    env.reset(seed=0)
    env.step(np.zeros(len(env.tracking.action)))
    record = env.record()
    assert record.motion.n_frames == 2 and record.human is SMALL
    normal = record.contact_force[0, :, 2]
    assert normal.max() < 3 * record.weight  # not started within a bump


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"form": "short"}, "lean, paper"),
        ({"start": 2.0}, "from 0 to 1"),
        ({"duration": 0.0}, "positive"),
        ({"render_mode": "human"}, "record"),
        ({"rate": 100.0}, "whole multiple"),
        ({"ground": "hill"}, "no ground 'hill'"),
        ({"grounds": "flat"}, "did you mean 'ground'"),
        ({"reach": 0.0}, "reach=0 rad must be positive"),
        ({"reach": np.nan}, "reach=nan rad must be positive"),
    ],
)
def test_what_cannot_be_is_refused(reference, options, said):
    with pytest.raises(ParameterError, match=said):
        WalkEnv(reference, **options)


@pytest.mark.wrong_types
@pytest.mark.parametrize("reference", [3, {}, [1.0], SMALL])
def test_what_is_no_reference_is_refused(reference):
    with pytest.raises(ParameterError, match="a reference must be a run, its folder or a record"):
        WalkEnv(reference)


@pytest.mark.parametrize("phase", [-0.1, 1.5, np.nan, "half"])
def test_an_episode_begins_within_the_stride(lean, phase):
    with pytest.raises(ParameterError, match="phase=.* from 0 to 1"):
        lean.reset(options={"phase": phase})


@pytest.mark.parametrize("wrong", [np.zeros(3), np.full(36, np.nan)])
def test_a_decision_is_a_finite_number_for_every_joint(lean, wrong):
    """MuJoCo would put zero torque in the place of NaN, and go on."""
    lean.reset(seed=0)
    with pytest.raises(ParameterError, match="finite numbers, for 1 persons"):
        lean.step(wrong)


def test_many_are_what_each_is_alone(reference):
    """The same starts and decisions; who falls begins anew in the same step."""
    envs = gymnasium.make_vec(learn.WALK, num_envs=3, reference=reference, duration=0.4)
    assert isinstance(envs.unwrapped, Walks) and envs.observation_space.shape == (3, 15 * 19 + 9)
    seen, infos = envs.reset(seed=5)
    alone = [WalkEnv(reference, duration=0.4) for _ in range(3)]
    for env, phase in zip(alone, infos["phase"], strict=True):
        env.reset(seed=0, options={"phase": float(phase)})
    rng = np.random.default_rng(1)
    for step in range(12):
        actions = rng.uniform(-0.2, 0.2, envs.action_space.shape).astype(np.float32)
        seen, rewards, terminated, truncated, infos = envs.step(actions)
        assert seen in envs.observation_space and seen.dtype == np.float32
        for i, env in enumerate(alone):
            own, reward, *over, info = env.step(actions[i])
            last = infos["final_obs"][i] if step == 11 else seen[i]
            np.testing.assert_allclose(last, own, atol=1e-5)
            assert rewards[i] == pytest.approx(reward) and over == [terminated[i], truncated[i]]
            assert infos["pose"][i] == pytest.approx(info["pose"])
    assert truncated.all() and infos["_final_obs"].all() and not np.allclose(seen[0], last)
    assert envs.reset(options={"phase": 0.25})[1]["phase"] == pytest.approx(0.25)
    again, _ = envs.reset(seed=5)
    other, _ = envs.reset(seed=[5, None, 7])
    assert not np.allclose(again, other)
    with pytest.raises(ParameterError, match="1 or more"):
        Walks(0, reference)


def test_what_moves_with_gains_is_commanded_in_full(reference):
    """The short way for fixed gains is the long one; variable gains are those asked for."""
    seen = []
    for gains in (False, True):
        env = WalkEnv(reference, gains=gains, start=0.3)
        env.reset(seed=0)
        action = np.zeros(len(env.tracking.action))
        action[3] = 0.4
        seen.append([env.step(action)[0] for _ in range(4)])
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-5)


def test_a_reference_is_walked_by_this_person_on_level_ground(reference):
    motion = standing(SMALL)
    record = Record(SMALL, motion)
    with pytest.raises(ParameterError, match="level ground"):
        ReferenceMotion.of(replace(record, ground=replace(record.ground, slope=0.1)))
    rough = replace(record.ground, bumps=(Bump((0.0, 0.0, -0.5), 0.52),))
    with pytest.raises(ParameterError, match="level ground"):
        ReferenceMotion.of(replace(record, ground=rough))
    gap = motion.qpos.copy()
    gap[2, 9] = np.nan
    with pytest.raises(ParameterError, match="without gaps"):
        ReferenceMotion.of_motion(SMALL, replace(motion, qpos=gap))
    with pytest.raises(ParameterError, match="of this person"):
        ReferenceMotion.of_motion(Human.create(joints="43"), motion)


def test_where_gymnasium_is_missing_the_extra_is_named(monkeypatch):
    for name in [n for n in sys.modules if n.startswith(("gymnasium", "plantigrade.learn"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(MissingExtra, match=r"pip install '.*\[learn\]'"):
        import plantigrade.learn.environment  # noqa: F401
