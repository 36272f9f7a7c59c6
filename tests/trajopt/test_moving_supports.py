"""Supports and ground that move: their motion, the dynamics on them, and what the check sees."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

import plantigrade as pg
from plantigrade import check
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.scene import SceneObject, scene_xml
from plantigrade.contact.site import foot_sites
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.dynamics.centroid import without_constraints
from plantigrade.errors import FileError, ParameterError
from plantigrade.record import Record
from plantigrade.record.scene_objects import scene_objects_of
from plantigrade.trajopt import (
    ContactBody,
    ProblemBuilder,
    make_task,
    parse_task_file,
    synthesize,
)
from plantigrade.trajopt.problem.dynamics import asked_by
from plantigrade.trajopt.tasks.settings import StandSettings
from plantigrade.trajopt.tasks.supported import on_moving_ground
from plantigrade.workflows.settings import SolveSettings
from plantigrade.workflows.synthesize import synthesize_task
from tests.models.presets import person

HUMAN = person("42", "rigid")
RIDE = """
[task]
name = "hand on a rail that moves, in a bus"
base = "standing"
nodes_per_second = 10

[parameters]
duration = 1.2

[ground]
motion = [[0.0, 0.0, 0.0, 0.0], [1.2, 0.4, 0.0, 0.0, 0.4, 0.0, 0.0]]

[[support]]
part = "hand_r"
place = [0.35, -0.25, 1.05]
motion = [[0.2, 0.0, 0.0, 0.0], [1.0, 0.0, -0.1, 0.0]]

[[term]]
type = "rest"
time = 0.0

[[term]]
type = "rest"
time = 1.2
"""


REST = RIDE[RIDE.index("[[term]]") :]


@cache
def riding() -> Record:
    """A person in a bus that gathers speed, a hand on a rail that also moves to the side."""
    task = parse_task_file(RIDE).task(HUMAN)
    made = synthesize(task.body_of(HUMAN), task)
    assert made.success
    return made.record()


def faults(record: Record) -> set[str]:
    return {f.quantity for f in check(record).findings}


def test_a_motion_has_what_its_rows_say_and_goes_on_with_their_acceleration():
    rows = ((1.0, 0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.5, 0.0, 0.0), (3.0, 0.4, 0.0, 0.0, 0.0, 0.6, 0.0))
    motion, times = SurfaceMotion(rows), np.array([1.0, 3.0])
    np.testing.assert_allclose(motion.displacement(times), [[0.1, 0.2, 0.3], [0.4, 0.0, 0.0]])
    np.testing.assert_allclose(motion.velocity(times), [[1.0, 0.0, 0.0], [0.0, 0.6, 0.0]])
    np.testing.assert_allclose(motion.acceleration(times)[0], [0.5, 0.0, 0.0], atol=1e-12)
    later, before = np.array([5.0]), np.array([0.0])
    np.testing.assert_allclose(motion.displacement(later), [[0.4, 1.2, 0.0]], atol=1e-12)
    np.testing.assert_allclose(motion.velocity(before), [[0.5, 0.0, 0.0]], atol=1e-12)


def test_position_velocity_and_acceleration_belong_together():
    motion = SurfaceMotion(
        ((0.5, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0), (1.0, 1.5, 0.1, 0.0), (2.0, 2.0, 0.0, 0.3))
    )
    times, h = np.linspace(0.0, 2.5, 101), 1e-5
    slope = (motion.displacement(times + h) - motion.displacement(times - h)) / (2 * h)
    np.testing.assert_allclose(slope, motion.velocity(times), atol=1e-6)
    bend = (motion.velocity(times + h) - motion.velocity(times - h)) / (2 * h)
    np.testing.assert_allclose(bend, motion.acceleration(times), atol=2e-3)


def test_accelerated_ground_is_tilted_gravity():
    """In axes that accelerate with the ground, gravity seems to be less that acceleration."""
    acceleration = np.array([1.2, -0.7, 0.9])
    carried = SurfaceMotion(((0.0, *np.zeros(6), *acceleration),))
    feet, rng = foot_sites(HUMAN), np.random.default_rng(1)
    body = ContactBody(HUMAN, feet, plan=ContactPlan(1.0, (), motion=carried), passive=False)
    q, v, a = (scale * rng.standard_normal((1, body.symbolic.nv)) for scale in (0.3, 1.0, 5.0))
    root, tau = asked_by(body, q, v, a, np.zeros((1, 3 * len(feet))), np.array([0.4]))
    model = without_constraints(HUMAN)
    model.opt.gravity = model.opt.gravity - acceleration
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qacc[:] = (x[0] for x in body.symbolic.to_mujoco(q, v, a))
    mujoco.mj_inverse(model, data)
    np.testing.assert_allclose(tau[0], data.qfrc_inverse[6:], atol=1e-8)
    np.testing.assert_allclose(root[0, :3] * body.weight, data.qfrc_inverse[:3], atol=1e-8)


@pytest.mark.solver
def test_a_rider_passes_and_the_same_motion_explains_itself_under_tilted_gravity():
    record = riding()
    assert check(record).status == "ok"
    times, model = record.motion.time, without_constraints(HUMAN)
    data, gravity, carried = mujoco.MjData(model), model.opt.gravity.copy(), record.ground.motion
    assert carried is not None
    away, speed, gain = (
        carried.displacement(times),
        carried.velocity(times),
        carried.acceleration(times),
    )
    for f in range(0, len(times), 7):
        model.opt.gravity[:] = gravity - gain[f]
        data.qpos[:], data.qvel[:], data.qacc[:] = (
            record.motion.qpos[f], record.motion.qvel[f], record.motion.qacc[f]
        )  # fmt: skip
        data.qpos[:3] -= away[f]
        data.qvel[:3] -= speed[f]
        data.qacc[:3] -= gain[f]
        mujoco.mj_inverse(model, data)
        left = data.qfrc_inverse[:3] - record.contact_force[f].sum(axis=0)
        assert np.abs(left).max() < 1e-3 * record.weight


@pytest.mark.solver
def test_what_joints_and_surfaces_do_is_what_the_body_gains():
    record = riding()
    verdict, time = check(record), record.motion.time
    joints = np.einsum("nj,nj->n", verdict.tau[:, 6:], record.motion.qvel[:, 6:])
    (rail,), force = record.ground.seats, np.nan_to_num(record.contact_force)
    speeds = [
        record.ground.velocity(time, rail if site.name == rail.site else None)
        for site in record.sites
    ]
    surfaces = np.einsum("nki,nki->n", force, np.stack(speeds, axis=1))
    model = without_constraints(HUMAN)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, energy = mujoco.MjData(model), []
    for f in (0, -1):
        data.qpos[:], data.qvel[:] = record.motion.qpos[f], record.motion.qvel[f]
        mujoco.mj_forward(model, data)
        energy.append(data.energy.sum())
    gained, done = energy[1] - energy[0], np.trapezoid(surfaces + joints, time)
    assert np.trapezoid(surfaces, time) > 2.0  # at least the kinetic energy of the bus
    assert done == pytest.approx(gained, abs=0.05)


@pytest.mark.solver
@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda ground: replace(ground, motion=None), "slip"),
        (lambda ground: replace(ground, motion=None), "condition"),
        (lambda ground: replace(ground, seats=(replace(ground.seats[0], motion=None),)), "slip"),
        (
            lambda ground: replace(
                ground,
                seats=(replace(ground.seats[0], motion=SurfaceMotion(((0.0, 0.0, 0.0, 0.03),))),),
            ),
            "penetration",
        ),
    ],
)
def test_the_check_sees_slip_and_penetration_relative_to_what_moves(change, fault):
    assert fault in faults(replace(riding(), ground=change(riding().ground)))


@pytest.mark.solver
def test_moving_ground_survives_a_file_and_is_in_model_and_pictures():
    ground, time = riding().ground, riding().motion.time
    assert Ground.from_dict(ground.to_dict()) == ground
    model = mujoco.MjModel.from_xml_string(scene_xml(HUMAN, ground))
    assert model.nmocap == 1 and model.nq == HUMAN.model.nq
    (board,) = scene_objects_of(riding())
    hand = [site.name for site in riding().sites].index("hand_r")
    apart = board.pose[:, :3] - riding().contact_point[:, hand]
    loaded = np.isfinite(apart).all(axis=1)
    assert np.ptp(apart[loaded], axis=0).max() < 1e-3
    np.testing.assert_allclose(ground.shifts(time)[-1, 0], [0.4, -0.1, 0.0], atol=1e-12)


def test_a_file_with_motions_written_again_is_the_same():
    file = parse_task_file(RIDE)
    assert parse_task_file(file.toml()) == file


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("[0.2, 0.0, 0.0, 0.0], [1.0", "[0.2, 0.0, 0.0], [1.0", r"support\]\] 1 motion.*rows"),
        ("[0.2, 0.0, 0.0, 0.0], [1.0", "[1.1, 0.0, 0.0, 0.0], [1.0", r"support\]\] 1.*increase"),
        ("[0.2, 0.0, 0.0, 0.0], [1.0", "[0.2, nan, 0.0, 0.0], [1.0", r"support\]\] 1 motion"),
        ("[0.2, 0.0, 0.0, 0.0], [1.0", "[0.2, inf, 0.0, 0.0], [1.0", r"support\]\] 1 motion"),
        ("[0.2, 0.0, 0.0, 0.0], [1.0", '["a", 0.0, 0.0, 0.0], [1.0', r"support\]\] 1 motion"),
        ("motion = [[0.0, 0.0", "motion = [] # ", r"\[ground\] motion"),
        ("motion = [[0.0, 0.0", 'motion = "forward" # ', r"\[ground\] motion"),
        ("[ground]\n", "[ground]\nspeed = 1.0\n", r"\[ground\].*unknown key 'speed'"),
        ("[ground]\n", "[[ground]]\n", r"ground.*table"),
        ("motion = [[0.0, 0.0", "# ", r"\[ground\].*missing"),
    ],
)  # fmt: skip
def test_what_a_motion_cannot_be_is_said_with_its_place(old, new, match):
    with pytest.raises(FileError, match=match):
        parse_task_file(RIDE.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("[1.0, 0.0, -0.1, 0.0]", "[1.0, 0.0, -3.0, 0.0]", r"hand_r.*m/s"),
        ("[0.2, 0.0, 0.0, 0.0], [1.0", "[0.9, 0.0, 0.0, 0.0], [1.0", r"hand_r.*m/s²"),
        ("[1.0, 0.0, -0.1, 0.0]", "[9.0, 0.0, -0.1, 0.0]", "hand_r.*outside the motion"),
        ("[1.2, 0.4, 0.0, 0.0, 0.4", "[1.2, 60.0, 0.0, 0.0, 60.0", "ground.*m/s"),
        ("[1.2, 0.4, 0.0, 0.0, 0.4, 0.0, 0.0]", "[1.2, 0.0, 0.0, -2.5]", "falls"),
    ],
)
def test_a_motion_that_nobody_follows_is_refused(old, new, match):
    with pytest.raises(ParameterError, match=match):
        parse_task_file(RIDE.replace(old, new)).task(HUMAN)


def test_a_task_that_ground_does_not_carry_along_is_refused():
    still = SurfaceMotion(((0.0, 0.0, 0.0, 0.0),))
    with pytest.raises(ParameterError, match="periodic"):
        on_moving_ground(make_task("hop", HUMAN, {}), still, HUMAN.gravity)
    box = SceneObject("box", "box", (0.1, 0.1, 0.1)), lambda times: np.zeros((len(times), 3))
    laden = replace(make_task("standing", HUMAN, {}), objects=(box,))
    with pytest.raises(ParameterError, match="objects"):
        on_moving_ground(laden, still, HUMAN.gravity)


@pytest.mark.solver
def test_controllers_know_only_what_is_at_rest():
    with pytest.raises(ParameterError, match="at rest"):
        pg.simulate(pg.Run(riding(), "synthesize"))
    with pytest.raises(ParameterError, match="replay"):
        synthesize_task(StandSettings(), SolveSettings(replay=True), file=parse_task_file(RIDE))


def test_feet_without_a_hold_need_friction():
    alone = RIDE.split("[[support]]")[0].replace(", 0.4", ", 5.0")
    with pytest.raises(ParameterError, match="feet slip"):
        parse_task_file(alone).task(HUMAN)


def test_gaits_that_repeat_and_bodies_of_another_plan_are_refused():
    carried = SurfaceMotion(((0.0, 0.0, 0.0, 0.0),))
    with pytest.raises(ParameterError, match="periodic"):
        ContactPlan(1.0, (), periodic=True, motion=carried)
    task = make_task("standing", HUMAN, {})
    moved = replace(task.plan, motion=carried)
    with pytest.raises(ParameterError, match="moves otherwise"):
        ProblemBuilder(ContactBody.for_plan(HUMAN, task.plan), moved, np.linspace(0.0, 2.0, 5))


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("acceleration", [1.5, -1.0])
def test_on_steadily_accelerating_ground_a_person_leans_by_the_tilt_of_gravity(acceleration):
    steady = f"motion = [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, {acceleration}, 0.0, 0.0]]"
    text = RIDE.split("[[support]]")[0].split("motion =")[0] + steady + "\n" + REST
    task = parse_task_file(text).task(HUMAN)
    made = synthesize(task.body_of(HUMAN), task)
    verdict = check(made.record())
    assert made.success and verdict.status == "ok"
    lean = (verdict.com - verdict.centre_of_pressure)[len(verdict.time) // 2]
    tilt = np.arctan(acceleration / HUMAN.gravity)
    assert np.arctan2(lean[0], lean[2]) == pytest.approx(tilt, abs=np.deg2rad(0.3))
