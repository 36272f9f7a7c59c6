"""The exported scene in plain MuJoCo: ground of the run, unchanged person, stable simulation."""

import mujoco
import numpy as np
import pytest

from plantigrade import Ground
from plantigrade.contact.ground import GroundStep, Seat
from plantigrade.contact.relief import Bump, HeightField
from plantigrade.contact.scene import scene_xml
from plantigrade.contact.site import ContactSite
from plantigrade.models import Human

PERSONS = {
    "42": Human.create(),
    "43 rigid": Human.create(1.55, 52.0, "female", "43"),
    "58": Human.create(1.6, 95.0, "female", "58", "multi-segment"),
    "66": Human.create(1.9, 80.0, joints="66"),
}
GROUNDS = {
    "flat": Ground(),
    "high": Ground(height=0.3),
    "uphill": Ground(slope=0.12),
    "downhill": Ground(slope=-0.12, friction=0.6),
    "step up": Ground(steps=(GroundStep(-0.5, 0.15), GroundStep(0.6, 0.3))),
    "step down": Ground(height=0.2, steps=(GroundStep(-0.5, 0.05),)),
    "stairs on a slope": Ground(slope=0.1, steps=(GroundStep(-0.5, 0.1), GroundStep(0.6, 0.2))),
    "relief": Ground(height=0.1, field=HeightField((-1.0, -1.0), (2.0, 2.0), ((0.1, 0.1),) * 2)),
    "bumps": Ground(bumps=(Bump((0.05, -0.08, -0.48), 0.5), Bump((0.05, 0.08, -0.48), 0.5))),
}


def scene(human: Human, ground: Ground, *sites: ContactSite):
    """Return model and data of a scene, standing."""
    model = mujoco.MjModel.from_xml_string(scene_xml(human, ground, sites))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


def held(model, data, seconds: float) -> float:
    """Simulate with springs that hold the posture; return the maximum foot penetration [m]."""
    posture = data.qpos[7:].copy()
    stiff = 4.0 * np.abs(model.jnt_actfrcrange[1:]).max(axis=1)
    deepest = 0.0
    for _ in range(int(seconds / model.opt.timestep)):
        data.ctrl[:] = stiff * (posture - data.qpos[7:]) - 0.1 * stiff * data.qvel[6:]
        mujoco.mj_step(model, data)
        deepest = max(deepest, -data.contact.dist.min(initial=0.0))
    return deepest


def lowest(model, data, ground: Ground) -> float:
    """Return the height of the lowest foot sphere over the ground [m]."""
    feet = [g for g in range(model.ngeom) if model.geom(g).name.startswith("contact_")]
    low = data.geom_xpos[feet] - model.geom_size[feet, :1] * ground.normal
    return float((low @ ground.normal - ground.under(low)).min())


@pytest.mark.parametrize("who", PERSONS)
def test_the_person_is_the_same(who):
    human = PERSONS[who]
    own, (model, data) = human.model, scene(human, Ground())
    for name in ("body_mass", "body_inertia", "body_pos", "jnt_axis", "jnt_range"):
        np.testing.assert_array_equal(getattr(model, name), getattr(own, name))
    assert [model.joint(j).name for j in range(model.njnt)] == list(human.joint_names)
    names = {own.geom(g).name for g in range(own.ngeom)}
    assert names <= {model.geom(g).name for g in range(model.ngeom)}
    np.testing.assert_allclose(data.qpos, human.standing(), atol=1e-9)


@pytest.mark.parametrize("who", PERSONS)
def test_every_hinge_has_a_motor_with_the_persons_limits(who):
    human = PERSONS[who]
    model, data = scene(human, Ground())
    assert [model.actuator(i).name for i in range(model.nu)] == list(human.coordinates)
    np.testing.assert_array_equal(model.actuator_ctrlrange, human.model.jnt_actfrcrange[1:])
    data.ctrl[:] = np.linspace(-500.0, 500.0, model.nu)
    mujoco.mj_forward(model, data)
    expected = np.clip(data.ctrl, *human.model.jnt_actfrcrange[1:].T)
    np.testing.assert_allclose(data.qfrc_actuator[6:], expected)
    assert (model.dof_armature[6:] > 0).all() and (model.dof_damping[6:] > 0).all()


@pytest.mark.parametrize("who", PERSONS)
def test_a_standing_person_touches_only_the_ground(who):
    model, data = scene(PERSONS[who], Ground(height=-1e-4))
    data.qpos[2] -= 5e-4
    mujoco.mj_forward(model, data)
    assert data.ncon > 0
    for pair in data.contact.geom:
        assert "floor" in {model.geom(g).name for g in pair}


@pytest.mark.parametrize("who", PERSONS)
def test_limbs_do_not_pass_through_each_other(who):
    human = PERSONS[who]
    model, data = scene(human, Ground())
    for side in "rl":  # legs crossed
        data.qpos[7 + human.hinge(f"hip_adduction_{side}")] = 0.4
    mujoco.mj_forward(model, data)
    touching = {frozenset(model.geom(g).name.split("_")[1] for g in c) for c in data.contact.geom}
    assert frozenset({"tibia"}) in touching or frozenset({"femur"}) in touching, touching


@pytest.mark.parametrize("who", PERSONS)
def test_a_passive_person_collapses_stably(who):
    model, data = scene(PERSONS[who], Ground())
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all() and np.abs(data.qvel).max() < 50.0
    assert not any(w.number for w in data.warning)


def test_a_person_with_posture_springs_stands_for_a_while():
    """Springs do not balance the body; it falls back over the heels after a second."""
    human = PERSONS["42"]
    model, data = scene(human, Ground())
    assert held(model, data, 0.75) < 0.005
    assert lowest(model, data, Ground()) > -0.005
    np.testing.assert_allclose(data.qpos[:3], human.standing()[:3], atol=0.04)


@pytest.mark.parametrize("where", GROUNDS)
def test_feet_touch_the_ground_where_it_is(where):
    """Dropped by a centimetre, the person lands on this ground and stays on it."""
    ground = GROUNDS[where]
    model, data = scene(PERSONS["42"], ground)
    assert lowest(model, data, ground) == pytest.approx(0.0, abs=1e-9)
    data.qpos[2] += 0.01
    assert held(model, data, 0.25) < 0.005
    assert abs(lowest(model, data, ground)) < 0.005
    surface = [g for g in range(model.ngeom) if model.geom_conaffinity[g] == 1]
    np.testing.assert_allclose(model.geom_friction[surface, 0], ground.friction)
    touched = {model.geom(g).name for pair in data.contact.geom for g in pair}
    assert touched & {model.geom(g).name for g in surface}


@pytest.mark.parametrize("where", ["step up", "step down", "stairs on a slope", "bumps", "uphill"])
def test_a_ray_meets_the_ground_at_its_height(where):
    ground = GROUNDS[where]
    check_rays(ground)


def test_relief_has_the_right_orientation():
    heights = ((0.0, 0.1, 0.2), (0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.0, 0.0, 0.3))
    check_rays(Ground(height=0.1, slope=0.1, field=HeightField((-0.5, 0.2), (0.7, 0.4), heights)))


def check_rays(ground: Ground) -> None:
    """Compare the scene with the ground along rays through it; at the points of a field exactly."""
    model, data = scene(PERSONS["42"], ground)
    data.qpos[2] = 100.0
    mujoco.mj_forward(model, data)
    rng = np.random.default_rng(0)
    places = rng.uniform(-2.0, 2.0, size=(60, 2))
    if ground.field is not None:
        (x, y), (dx, dy) = ground.field.corner, ground.field.spacing
        ny, nx = np.shape(ground.field.heights)
        places = [(x + i * dx, y + j * dy) for i in range(1, nx - 1) for j in range(1, ny - 1)]
        places += [(x + 1e-6, y + j * dy) for j in range(1, ny - 1)]
        places += [(x + i * dx, y + 1e-6) for i in range(1, nx - 1)]
    for place in places:
        start = ground.to_world @ [*place, 5.0]
        hit = np.zeros(1, np.int32)
        far = mujoco.mj_ray(model, data, start, -ground.normal, None, 1, -1, hit, None)
        height = float(ground.under(start))
        assert 5.0 - far == pytest.approx(height, abs=1e-4), (place, model.geom(int(hit[0])).name)


def test_a_seat_carries_a_sitting_person():
    human = PERSONS["42"]
    site = ContactSite(
        body="pelvis", position=(-0.06, 0.0, -0.15), radius=0.05, name="seat_r", part="chair"
    )
    ground = Ground(seats=(Seat("seat_r", (-0.06, 0.0, 0.6)),))
    model, data = scene(human, ground, site)
    for side in "rl":  # thighs level, shanks down
        data.qpos[7 + human.hinge(f"hip_flexion_{side}")] = np.pi / 2
        data.qpos[7 + human.hinge(f"knee_angle_{side}")] = np.pi / 2
    data.qpos[2] = 0.6 + 0.15 + 0.05 + 0.005
    held(model, data, 0.1)
    sphere = data.geom("contact_seat_r")
    assert sphere.xpos[2] - 0.05 == pytest.approx(0.6, abs=0.005)
    touching = {frozenset(model.geom(g).name for g in c) for c in data.contact.geom}
    assert frozenset({"seat_0", "contact_seat_r"}) in touching
