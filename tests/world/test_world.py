"""The world obeys physics, whatever moves the person, and says the same twice."""

import mujoco
import numpy as np
import pytest

from plantigrade.analyze.check import check
from plantigrade.constants import GRAVITY
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.control import Posture, passive
from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.models import Human
from plantigrade.world import (
    PD,
    Acceleration,
    Push,
    StablePD,
    Torque,
    World,
    standing_on,
)
from tests.world.yielding import yielding

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")
LARGE = Human.create(1.5, 48.5, joints="66")


def standing(human: Human = HUMAN, **options) -> World:
    return World(human, **{"rate": 300.0, **options})


@pytest.fixture(scope="module")
def pushed():
    """Half a second of standing, pushed to the left from 0.2 to 0.3 s; and its world."""
    push = Push(force=80.0, duration=0.1, direction=np.pi / 2, time=0.2)
    world = standing(disturbances=(push,))
    return world, world.simulate(Posture(), 0.5)


@pytest.mark.parametrize("human", [HUMAN, LARGE])
def test_a_body_has_the_same_accelerations_dense_and_sparse(human):
    """MuJoCo 4.0.0 has others: wrong where Jacobians are sparse, from 60 coordinates on."""
    world = standing(human)
    for _ in range(10):
        world.step(StablePD(world.data.qpos[7:].copy()))
    model, data, found = world.model, world.data, []
    assert mujoco.mj_isSparse(model)
    for jacobian in (mujoco.mjtJacobian.mjJAC_DENSE, mujoco.mjtJacobian.mjJAC_SPARSE):
        model.opt.jacobian = jacobian
        own = mujoco.MjData(model)
        own.qpos[:], own.qvel[:], own.ctrl[:] = data.qpos, data.qvel, data.ctrl
        mujoco.mj_forward(model, own)
        assert own.ncon >= 8
        found.append(own.qacc.copy())
    scale = np.abs(found[0]).max()
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-6 * max(scale, 1.0))


def test_every_frame_obeys_the_equations_of_motion(pushed):
    """Also while it is pushed: the checker's own inverse dynamics, without the world's armature."""
    _, record = pushed
    assert record.motion.n_frames == 51 and record.motion.time[-1] == pytest.approx(0.5)
    verdict = check(record)
    for quantity in ("root_force", "root_moment"):
        assert verdict.measures[quantity].value < 0.05  # % of body weight
    torque = record.qfrc_actuator[:, 6:]
    np.testing.assert_allclose(verdict.tau[:, 6:], torque, atol=1e-3 * np.abs(torque).max())
    for quantity in ("friction", "adhesion", "slip"):
        assert not verdict.measures[quantity].bad, quantity
    assert verdict.measures["penetration"].value < yielding(record)


def test_a_push_is_a_signal_and_a_site_and_moves_the_body(pushed):
    world, record = pushed
    during = (record.motion.time > 0.199) & (record.motion.time < 0.299)
    force = record.signals["world.push"]
    np.testing.assert_allclose(force[during], [[0.0, 80.0, 0.0]] * during.sum(), atol=1e-9)
    assert not force[~during].any()
    assert record.sites[-1].part == "push" and record.sites[-1].side == ""
    assert record.motion.qpos[-1, 1] > 0.002 and world.fall is None


def test_momentum_is_the_impulse_of_what_acts():
    """In the air, pushed: momentum of the centre of mass, exactly; the angular one is kept."""
    push = Push(force=100.0, duration=0.05, direction=0.3, time=0.02)
    world = standing(disturbances=(push,), passive=False)
    qpos = world.reset().qpos.copy()
    qpos[2] += 1.0
    state = world.reset(qpos=qpos, qvel=np.r_[np.zeros(6), np.full(len(HUMAN.coordinates), 0.5)])
    before = state.body.com_velocity
    for _ in range(10):
        state = world.step()
    change = HUMAN.mass * (state.body.com_velocity - before)
    impulse = push.vector * 0.05 + [0.0, 0.0, -HUMAN.mass * GRAVITY * 0.1]
    np.testing.assert_allclose(change, impulse, rtol=2e-3, atol=2e-2)


def test_the_same_seed_gives_the_same_motion():
    def shaky(state):
        return StablePD(state.angles + 0.05 * state.world.random.normal(size=len(state.angles)))

    world = standing()
    first, other, again = (world.simulate(shaky, 0.2, seed=s) for s in (1, 2, 1))
    assert np.array_equal(first.motion.qpos, again.motion.qpos)
    assert not np.array_equal(first.motion.qpos, other.motion.qpos)


def test_commands_hold_a_joint_each_in_its_way():
    """In the air without gravity, the same knee: torque accelerates it, springs bring it there."""
    knee = HUMAN.hinge("knee_angle_r")
    n = len(HUMAN.coordinates)
    world = standing(passive=False, control_rate=300.0)
    world.model.opt.gravity[:] = 0.0
    start = standing_on(HUMAN, Ground())
    start[2] += 1.0
    target = start[7:].copy()
    target[knee] += 0.3
    expected = np.zeros(n)
    expected[knee] = 2.0

    def after(command, steps):
        state = world.reset(qpos=start, qvel=np.zeros(HUMAN.model.nv))
        for _ in range(steps):
            state = world.step(command)
        return state

    state = after(Acceleration(expected), 30)
    np.testing.assert_allclose(state.rates, 0.1 * expected, atol=5e-3)
    state = after(StablePD(target), 300)
    assert abs(state.angles[knee] - target[knee]) < 0.02
    tau = np.zeros(n)
    tau[knee] = 3.0
    pulled, same = after(Torque(tau), 3), after(tau, 3)
    assert pulled.rates[knee] > 0.05 and np.array_equal(pulled.qpos, same.qpos)
    soft = after(PD(target, stiffness=20.0, damping=1.0), 3)
    assert 0 < soft.rates[knee] < 20.0 * 0.3 * 0.01 / 0.05
    assert np.array_equal(after(None, 5).rates, np.zeros(n))


def test_stable_pd_is_calm_where_plain_pd_chatters():
    """Strong springs on the light foot of many segments, at 150 steps a second."""
    world = World(LARGE, rate=150.0, control_rate=30.0, recording=False)
    target = world.reset().angles.copy()
    strong = {"stiffness": 400.0, "damping": 40.0}
    for kind, stays in ((StablePD, True), (PD, False)):
        state = world.reset()
        for _ in range(15):
            state = world.step(kind(target, **strong))
        calm = world.diverged is None and bool(np.abs(state.rates).max() < 1.0)
        assert calm is stays


def test_motors_keep_to_the_strength_of_the_joints():
    world = standing()
    record = world.simulate(lambda s: np.full(len(s.angles), 1e4), 0.05)
    np.testing.assert_allclose(
        record.signals["world.motor"], [HUMAN.model.jnt_actfrcrange[1:, 1]] * 6, rtol=1e-9
    )


def test_a_body_that_is_left_alone_falls_and_feet_alone_are_no_fall():
    world = standing(rate=300.0)
    record = world.simulate(passive, 1.0)
    assert world.fall is not None and 0.2 < world.fall.time < 1.0
    assert f"fell at {world.fall.time:.2f} s" in record.notes[0]
    assert record.motion.qpos[-1, 2] > 0.0  # the ground stops what falls on it
    assert {s.part for s in record.sites} == {"", "touch"}
    assert check(record).measures["root_force"].value < 0.1


def test_a_world_that_diverges_stops_and_keeps_what_was_good():
    world = standing(record_rate=300.0)

    def mad(state):
        return None if state.time < 0.1 else Acceleration(np.full(len(state.angles), 1e5))

    record = world.simulate(mad, 1.0)
    assert world.diverged is not None and 0.1 < world.diverged < 0.2
    assert np.isfinite(record.motion.qpos).all() and np.isfinite(record.contact_force).all()
    assert np.abs(record.motion.qvel).max() < 5.0  # of the step that went wrong nothing is kept
    assert record.motion.time[-1] > 0.095 and "diverged at" in record.notes[-1]
    assert world.step().time == world.time


def test_what_controllers_say_is_kept():
    world = standing()

    def talking(state):
        said = {"phase": state.time} | ({"late": np.ones(2)} if state.time > 0.03 else {})
        return StablePD(state.angles, signals=said)

    record = world.simulate(talking, 0.1)
    phase, late = record.signals["controller.phase"], record.signals["controller.late"]
    np.testing.assert_allclose(phase[:-1], record.motion.time[:-1], atol=1e-9)
    assert np.isnan(late[0]).all() and late.shape == (11, 2) and (late[-1] == 1).all()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("knee", "a controller returned str"),
        (Torque(np.zeros(3)), "torque must be 29 finite numbers"),
        (StablePD(np.full(29, np.nan)), "target must be 29"),
        (StablePD(np.zeros(29), stiffness=-1.0), "not be negative"),
    ],
)
@pytest.mark.wrong_types
def test_what_is_no_command_is_refused(command, words):
    n = len(HUMAN.coordinates)
    with pytest.raises(ParameterError, match=words.replace("29", str(n))):
        standing().step(command)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"rate": 1000.0, "control_rate": 300.0}, "whole multiple.* such as"),
        ({"rate": 100.0, "control_rate": 200.0}, "at most rate"),
        ({"qpos": np.zeros(3)}, "must be .* numbers in one row"),
        ({"qpos": np.full(36, np.nan)}, "finite"),
    ],
)
def test_what_is_no_world_is_refused(options, words):
    with pytest.raises(ParameterError, match=words):
        World(HUMAN, **options)


def test_pushes_are_refused_before_any_work():
    with pytest.raises(CoordinateNotFound, match="no body 'wing'"):
        World(HUMAN, disturbances=(Push(force=1.0, duration=1.0, body="wing"),))
    for word in ("1,2,3", "a,b,c,d", "1,0,0,0", "1,1,0,-1", "nan,1,1,1"):
        with pytest.raises(ParameterError, match="push|Push"):
            Push.parse(word)


def test_torques_rise_in_a_finite_time():
    world = standing(torque_rise=0.1, rate=600.0)
    record = world.simulate(lambda s: np.full(len(s.angles), 1e4), 0.05)
    most = HUMAN.model.jnt_actfrcrange[1:, 1]
    share = record.signals["world.motor"] / most
    np.testing.assert_allclose(
        share, (record.motion.time / 0.1)[:, None] * np.ones(len(most)), atol=0.03
    )


def test_a_record_may_be_taken_on_the_way():
    world = standing()
    for _ in range(3):
        world.step()
    first, again = world.record(), world.record()
    assert first.motion.n_frames == again.motion.n_frames == 4
    world.step()
    np.testing.assert_allclose(world.record().motion.time, np.arange(5) / 100.0, atol=1e-9)


def test_what_diverges_at_once_still_has_its_first_frame():
    world = standing()
    record = world.simulate(lambda s: Acceleration(np.full(len(s.angles), 1e5)), 0.1)
    assert world.diverged == pytest.approx(0.01) and record.motion.n_frames == 1
    np.testing.assert_allclose(record.motion.qpos[0], world.reset().qpos)


def test_a_hand_that_touches_the_ground_in_the_motion_is_no_fall():
    """Elsewhere it is one, and so is a knee."""
    human = HUMAN
    reach = human.standing()
    reach[2] -= 0.42
    names = {"hip_flexion": 1.9, "knee_angle": 1.7, "ankle_angle": 0.3}
    for name, angle in names.items():
        for side in "rl":
            reach[7 + human.hinge(f"{name}_{side}")] = angle
    reach[7 + human.hinge("lumbar_extension")] = -1.0
    reach[7 + human.hinge("arm_flex_r")] = 1.2
    data = mujoco.MjData(human.model)
    data.qpos[:] = reach
    mujoco.mj_kinematics(human.model, data)
    hand = min(data.xpos[human.body(f"fingers_{side}"), 2] for side in "rl")
    reach[2] -= hand - 0.03
    for allowed in (False, True):
        world = World(human, qpos=reach)
        if allowed:
            world.allow_contacts_of(np.array([reach]))
        world.step(StablePD(reach[7:]))
        world.step(StablePD(reach[7:]))
        touched = world.fall is not None and world.fall.body[:7] == "fingers"
        assert touched != allowed
    edge = Ground(steps=(GroundStep(2.0, 0.3),))  # heights differ: a hand that is low tells nothing
    world = World(human, edge, qpos=reach)
    world.allow_contacts_of(np.array([reach]))
    world.step(StablePD(reach[7:]))
    world.step(StablePD(reach[7:]))
    assert world.fall is not None
