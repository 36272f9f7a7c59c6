"""A policy is one file that walks with NumPy alone, alike in the environment and in a world."""

import json

import mujoco
import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.learn import Policy, PolicyController, ReferenceMotion, Rules, WalkEnv
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.mirror import Mirror, asymmetry
from plantigrade.learn.parallel_tracking import ParallelTracking
from plantigrade.learn.policy import shipped, survival_times
from plantigrade.learn.transfer import transfer_policy
from plantigrade.models import Human
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.workflows.simulate import simulate
from plantigrade.world import StablePD, World

SMALL = Human.create(1.7, 65.0, "female", "42", "two-segment")


@pytest.fixture(scope="module")
def reference():
    return ReferenceMotion.textbook(SMALL)


@pytest.fixture(scope="module")
def policy(reference):
    """A policy that decides little, but differently in every state."""
    tracking = ParallelTracking(Rules(reference=reference, gains=True, passive=True, mirrored=True))
    rng = np.random.default_rng(0)
    sizes = (len(tracking.observation), 8, 8, 8, len(tracking.action))
    layers = tuple(
        (
            rng.normal(size=(i, o)).astype(np.float32) / np.float32(np.sqrt(i)),
            0.1 * rng.normal(size=o).astype(np.float32),
        )
        for i, o in zip(sizes[:-1], sizes[1:], strict=True)
    )
    layers = (*layers[:-1], (0.1 * layers[-1][0], layers[-1][1]))
    mean, scale = np.zeros(sizes[0], np.float32), np.ones(sizes[0], np.float32)
    about = {"seed": 0}
    return Policy(layers=layers, mean=mean, scale=scale, rules=tracking.resolved_rules, about=about)


def test_a_network_computes_what_torch_did(policy):
    """``torch.nn.Sequential(Linear(3, 4), ELU(), Linear(4, 2))`` of torch 2.13, a wide scale."""
    layers = (
        ([[0.0, -0.8, 0.0, 0.3], [0.6, -0.4, 0.9, -0.3], [-1.0, 0.3, -0.1, -0.2]],
         [-1.1, -0.8, -0.5, 0.0]),
        ([[0.4, 0.4], [0.6, 0.8], [-0.7, -0.2], [-0.4, 0.7]], [-0.2, 0.1]),
    )  # fmt: skip
    made = Policy(
        layers=tuple((np.array(w, np.float32), np.array(b, np.float32)) for w, b in layers),
        mean=np.array([1.0, 1.0, 1.0], np.float32),
        scale=np.array([2.0, 2.0, 2.0], np.float32),
        rules=policy.rules,
        about={},
    )
    seen = 2.0 * np.array([[0.5, -1.0, 2.0], [-0.3, 0.1, 0.7]], np.float32) + 1.0
    recorded = [[-0.16019972, -0.24050531], [-0.36512673, -0.57216686]]
    np.testing.assert_allclose(made(seen), recorded, atol=1e-6)


def test_a_policy_is_read_as_it_was_written(policy, tmp_path):
    path = policy.save(tmp_path / "policy.npz")
    again = Policy.load(path)
    assert again.save(tmp_path / "again.npz").read_bytes() == path.read_bytes()
    assert not list(tmp_path.glob(".*"))
    seen = np.random.default_rng(1).normal(size=(3, len(policy.mean))).astype(np.float32)
    np.testing.assert_array_equal(again(seen), policy(seen))
    assert again.rules.mirrored and again.rules.base == policy.rules.base
    assert again.reference.human.to_dict() == SMALL.to_dict() and again.about == {"seed": 0}
    time = np.array([0.3, 2.0])
    np.testing.assert_allclose(
        again.reference.at(time).qpos, policy.reference.at(time).qpos, atol=1e-5
    )


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"about": np.array("{}")}, "not a policy of this version"),
        ({"about": np.array("none")}, "not a policy of this version"),
        ({"mean": np.zeros(3)}, "mean: has shape"),
        ({"weight_1": np.full((8, 8), np.nan)}, "weight_1: holds numbers that are not finite"),
        ({"weight_3": np.zeros((8, 7)), "bias_3": np.zeros(7)}, "ends in 7 numbers, not 38"),
        ({"scale": None}, "scale: is missing"),
        ({"reference": np.zeros((5, 9))}, "reference: has shape"),
        ({"about": np.array("[" * 100_000)}, "not a policy of this version"),
        ({"scale": np.zeros(294)}, "standard deviation that is not positive"),
        ({"reference": np.zeros((5, 101))}, "rotations of the pelvis are invalid"),
        ({"mean": np.array([{}], dtype=object)}, "no whole npz|not a whole npz"),
    ],
)
def test_what_is_no_policy_is_refused(policy, tmp_path, changed, said):
    path = policy.save(tmp_path / "policy.npz")
    with np.load(path) as file:
        arrays = {k: v for k, v in {**file, **changed}.items() if v is not None}
    np.savez(path, **arrays)
    with pytest.raises(FileError, match=said):
        Policy.load(path)


def test_rules_that_cannot_be_are_refused(policy, tmp_path):
    path = policy.save(tmp_path / "policy.npz")
    with np.load(path) as file:
        arrays = dict(file)
    about = json.loads(str(arrays["about"]))
    for part, name, value, said in (
        ("rules", "form", "short", "lean, paper"),
        ("rules", "control_rate", None, "control_rate must be 1"),
        ("rules", "passive", "no", "passive must be true or false"),
        ("rules", "extra", 1, "'extra' is unknown"),
        ("base", "stiffness", 10**400, "stiffness must be 0"),
        ("base", "damping", float("nan"), "damping must be 0"),
        (None, "period", -1.0, "period must be 0.05"),
        (None, "stride", float("inf"), "stride must be -100"),
    ):
        wrong = json.loads(json.dumps(about))
        (wrong if part is None else wrong[part])[name] = value
        np.savez(path, **{**arrays, "about": np.array(json.dumps(wrong))})
        with pytest.raises(FileError, match=said):
            Policy.load(path)


def test_in_a_world_a_policy_does_what_it_does_in_the_environment(policy):
    """To the last digit: it sees a state alone, and the same decisions act."""
    env = ParallelTracking(policy.rules)
    env.start_episodes([0], [0.45], [0])
    controller = PolicyController(policy, begin=0.45)
    first = controller.record.motion
    world = World(
        SMALL, rate=150.0, control_rate=30.0, exact_limits=False, recording=False,
        qpos=first.qpos[0], qvel=first.qvel[0],
    )  # fmt: skip
    for name in ("solver", "iterations"):
        setattr(world.model.opt, name, getattr(env.worlds[0].model.opt, name))
    state = world.reset()
    for _ in range(6):  # through the middle of the stride, from where it sees a mirror
        command = controller(state)
        assert len(command.signals["foot_stiffness"]) == len(controller.joints) == 4
        state = world.step(command)
        env.step(policy(env.observations()))
        np.testing.assert_allclose(state.qpos, env.worlds[0].data.qpos, atol=1e-9)
    assert 0.0 < command.signals["tracking_error"] < 0.2


def test_a_policy_is_judged_by_how_long_it_walks(policy):
    found = survival_times(policy, ParallelTracking(policy.rules, 2), 3.0)
    assert found.shape == (2,) and (found > 0.2).all() and (found < 3.0).all()


def test_in_the_mirror_everything_is_on_the_other_side(reference):
    """Two persons who are mirror images see the same, but for the way they have gone."""
    tracking = ParallelTracking(Rules(reference=reference, gains=True), 2)
    tracking.start_episodes([0, 1], [0.1, 0.6], [0, 0])
    first, second = (world.data for world in tracking.worlds)
    rng, names = np.random.default_rng(0), list(SMALL.coordinates)
    other = [names.index(mirrored_name(name)) for name in names]
    sign, across = np.array([mirror_sign(name) for name in names]), np.diag([1.0, -1.0, 1.0])
    first.qpos[7:] += 0.1 * rng.normal(size=len(names))
    first.qpos[3:7] += 0.1 * rng.normal(size=4)
    first.qpos[3:7] /= np.linalg.norm(first.qpos[3:7])
    first.qvel[:] += rng.normal(size=len(first.qvel))
    second.qpos[:3], second.qvel[:3] = across @ first.qpos[:3], across @ first.qvel[:3]
    second.qpos[7:], second.qvel[6:] = first.qpos[7:][other] * sign, first.qvel[6:][other] * sign
    turn, quat = np.zeros(9), np.zeros(4)
    mujoco.mju_quat2Mat(turn, first.qpos[3:7])
    mujoco.mju_mat2Quat(quat, (across @ turn.reshape(3, 3) @ across).ravel())
    second.qpos[3:7] = quat
    second.qvel[3:6] = -across @ first.qvel[3:6]
    view = BatchState(SMALL, [(w.model, w.data) for w in tracking.worlds])
    view.update()
    frame = tracking.reference.at(tracking.time)
    look = tracking.form.observe(view, frame, tracking.phase)
    mirror, off = Mirror(SMALL, tracking.action), slice(-5, -2)  # its way is another
    seen = mirror.mirror_observation(look[:1])[0]
    np.testing.assert_allclose(np.delete(seen, off), np.delete(look[1], off), atol=1e-5)
    np.testing.assert_allclose(mirror.mirror_observation(mirror.mirror_observation(look)), look)
    decided = rng.uniform(-1, 1, (2, len(tracking.action)))
    np.testing.assert_allclose(mirror.mirror_action(mirror.mirror_action(decided)), decided)
    # In the mirror they move alike, too.
    decided[1:] = mirror.mirror_action(decided[:1])
    for world in tracking.worlds:
        world.model.opt.solver, world.model.opt.iterations = mujoco.mjtSolver.mjSOL_NEWTON, 100
    targets = tracking.action.targets(decided, frame) - frame.qpos[:, 7:]
    for world, target in zip(tracking.worlds, targets, strict=True):
        world.advance(StablePD(world.data.qpos[7:] + target, stiffness=400.0, damping=40.0))
    np.testing.assert_allclose(second.qpos[7:], first.qpos[7:][other] * sign, atol=1e-6)
    np.testing.assert_allclose(second.qvel[:3], across @ first.qvel[:3], atol=1e-5)
    assert np.abs(first.qvel[1]) > 1e-3 and first.ncon > 0
    assert asymmetry(reference) < np.deg2rad(1.0)


def test_only_an_even_stride_is_learned_in_the_mirror(reference):
    table = reference.table.copy()
    table[:, 7 + SMALL.hinge("knee_angle_r")] += 0.5
    limp = ReferenceMotion(SMALL, reference.period, reference.stride, True, table)
    with pytest.raises(ParameterError, match="a symmetric stride"):
        WalkEnv(limp, mirrored=True)
    with pytest.raises(ParameterError, match="needs form='lean'"):
        WalkEnv(reference, mirrored=True, form="paper")


@pytest.mark.parametrize("passive", [False, True])
def test_many_motors_are_commanded_as_one_is(reference, passive):
    rules = Rules(reference=reference, gains=True, passive=passive)
    together, alone = (ParallelTracking(rules, 2) for _ in range(2))
    for each in (together, alone):
        each.start_episodes([0, 1], [0.1, 0.6], [0, 0])
    rng = np.random.default_rng(0)
    for _ in range(3):
        decided = rng.uniform(-1.0, 1.0, (2, len(together.action)))
        frame = together.reference.at(together.time + 1.0 / 30.0)
        target = together.action.targets(decided, frame)
        stiffness, damping = together.action.gains_of(decided)
        together.step(decided)
        for i, world in enumerate(alone.worlds):
            rates = frame.qvel[i, 6:]
            command = StablePD(target[i], rates, stiffness=stiffness[i], damping=damping[i])
            world.advance(command)
            np.testing.assert_array_equal(world.data.qpos, together.worlds[i].data.qpos)


def test_a_policy_is_simulated_like_any_controller(policy, tmp_path):
    path = policy.save(tmp_path / "mine.npz")
    run = simulate(controller=str(path), duration=0.3, rate=150.0)
    assert run.record.human.to_dict() == SMALL.to_dict() and run.name == "simulate-mine"
    assert run.record.signals["controller.foot_stiffness"].shape[1] == 4
    assert "motion" in run.record.references
    with pytest.raises(ParameterError, match="leave out height"):
        simulate(controller=str(path), height=1.8)
    with pytest.raises(ParameterError, match="brings its own motion"):
        simulate(path, controller=str(path))
    with pytest.raises(FileError, match="no such file"):
        simulate(controller="nothing.npz")


def test_what_was_learned_begins_a_policy_of_other_feet(policy, reference):
    """Bodies and hinges are found by their names; the toes are nobody's to begin with."""
    same, mean, scale = transfer_policy(policy, SMALL, policy.rules)
    for mine, theirs in zip(same, policy.layers, strict=True):
        np.testing.assert_array_equal(mine[0], theirs[0])
        np.testing.assert_array_equal(mine[1], theirs[1])
    other = Human.create(1.7, 65.0, "female", "42", "rigid")
    layers, mean, scale = transfer_policy(policy, other, policy.rules)
    n, m = len(other.body_names), len(SMALL.body_names)
    assert n < m and layers[0][0].shape == (15 * n + 9, 8) and len(mean) == len(scale) == 15 * n + 9
    mine, theirs = other.body_names.index("foot_r"), SMALL.body_names.index("foot_r")
    for block in (0, 4):
        np.testing.assert_array_equal(
            layers[0][0][3 * (block * n + mine)], policy.layers[0][0][3 * (block * m + theirs)]
        )
    back, *_ = transfer_policy(
        Policy(layers=layers, mean=mean, scale=scale, about={},
               rules=ParallelTracking(
                   Rules(reference=ReferenceMotion.textbook(other), gains=True)).resolved_rules),
        SMALL, policy.rules,
    )  # fmt: skip
    toes = SMALL.body_names.index("toes_r")
    assert (back[0][0][3 * toes] == 0.0).all() and (back[0][0][3 * theirs] != 0.0).any()
    with pytest.raises(ParameterError, match="form='lean'"):
        transfer_policy(policy, other, Rules(reference=reference, form="paper"))


@pytest.mark.parametrize("feet", ["multi-segment", "two-segment", "rigid"])
def test_the_policies_of_the_package_walk(feet):
    """From two instants of the stride; with the feet that they name."""
    policy = Policy.load(shipped(feet))
    assert policy.reference.human.feet == feet and policy.reference.human.joints == "66"
    assert shipped(feet).stat().st_size < 2**20
    assert (survival_times(policy, ParallelTracking(policy.rules, 2), 1.5) == 1.5).all()
    with pytest.raises(ParameterError, match="controller=learned walks on feet="):
        shipped("stilts")
