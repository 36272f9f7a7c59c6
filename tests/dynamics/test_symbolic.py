"""The symbolic body against MuJoCo, and against what the laws of motion say of any body."""

import subprocess
import sys
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.contact.site import Point, contact_sites
from plantigrade.dynamics.centroid import centroid, without_constraints
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.dynamics.symbolic import ROOTS, SymbolicHuman
from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD
from tests.dynamics.opensim_moments import opensim_moments
from tests.models.presets import person

ca = pytest.importorskip("casadi")

BODIES = [
    ("42", "two-segment"),
    ("43", "two-segment"),
    ("66", "multi-segment"),
    ("42", "rigid"),
    ("58", "multi-segment"),
]


class Case:
    """One person's symbolic body, a random state of it, and MuJoCo in the same state."""

    def __init__(self, human, seed=0):
        self.human, self.body = human, SymbolicHuman(human)
        rng = np.random.default_rng(seed)
        nv = self.body.nv
        self.q, self.qd, self.qdd = rng.normal(size=(3, nv))
        self.q[6:] = rng.uniform(*human.limits)
        self.points = (
            *contact_sites(self.human),
            Point("head", (0.02, -0.03, 0.1)),
            Point(human.body_names[5], (0.0, 0.01, -0.05), 0.03),
            Point("pelvis"),
        )
        self.forces = rng.normal(size=(3, len(self.points))) * 200.0
        qpos, qvel, qacc = self.body.to_mujoco(*(x[None] for x in (self.q, self.qd, self.qdd)))
        self.motion = qpos, qvel, qacc
        self.m = without_constraints(human)
        self.d = mujoco.MjData(self.m)
        self.d.qpos, self.d.qvel = qpos[0], qvel[0]
        mujoco.mj_forward(self.m, self.d)
        self.d.qacc = qacc[0]
        mujoco.mj_inverse(self.m, self.d)

    @property
    def state(self):
        return self.q, self.qd, self.qdd

    def world_points(self):
        """Body and world place of every point, by MuJoCo's kinematics."""
        for point in self.points:
            b = self.human.body(point.body)
            place = self.d.xpos[b] + self.d.xmat[b].reshape(3, 3) @ point.position
            yield b, place - [0.0, 0.0, point.radius]


def close(ours, theirs):
    """Agreement to 1e-9 of the largest entry."""
    ours, theirs = np.squeeze(np.array(ours)), np.squeeze(np.array(theirs))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max())


@pytest.fixture(scope="module", params=BODIES, ids="-".join)
def case(request):
    return Case(person(*request.param))


def test_names_are_the_order_of_coordinates(case):
    names, values = case.human.to_coordinates(case.motion[0])
    assert case.body.names == names
    np.testing.assert_allclose(np.cos(values - case.q), 1.0, atol=1e-12)


def test_mujocos_variables_come_back(case):
    for ours, theirs in zip(case.body.from_mujoco(*case.motion), case.state, strict=True):
        close(ours, theirs)


def test_velocity_and_acceleration_are_derivatives_of_the_configuration(case):
    """Along q + t qd + t²/2 qdd, by central differences in MuJoCo's variables."""
    t = 1e-5 * np.array([-1.0, 0.0, 1.0])[:, None]
    q = case.q + t * case.qd + t**2 / 2 * case.qdd
    qpos, qvel, qacc = case.body.to_mujoco(q, case.qd + t * case.qdd, np.tile(case.qdd, (3, 1)))
    v = np.zeros(case.m.nv)
    mujoco.mj_differentiatePos(case.m, v, 2e-5, qpos[0], qpos[2])
    np.testing.assert_allclose(v, qvel[1], atol=1e-7)
    np.testing.assert_allclose((qvel[2] - qvel[0]) / 2e-5, qacc[1], atol=1e-6)


@pytest.mark.filterwarnings("ignore:Gimbal lock")
def test_a_list_of_90_degrees_has_no_rates(case):
    q = case.q.copy()
    q[1] = np.pi / 2
    motion = case.body.to_mujoco(*(x[None] for x in (q, case.qd, case.qdd)))
    with pytest.raises(ParameterError, match="lists by 90° in frame 0"):
        case.body.from_mujoco(*motion)


def test_frames(case):
    position, rotation = case.body.frames()(case.q)
    close(position, case.d.xpos[1:].T)
    close(rotation, np.hstack(case.d.xmat[1:].reshape(-1, 3, 3)))
    omega = case.body.angular_velocities()(case.q, case.qd)
    velocity = np.zeros(6)
    for b in range(1, case.m.nbody):
        mujoco.mj_objectVelocity(case.m, case.d, mujoco.mjtObj.mjOBJ_BODY, b, velocity, 0)
        np.testing.assert_allclose(np.array(omega)[:, b - 1], velocity[:3], atol=1e-12)


def test_points(case):
    b, points = case.body, case.points
    position = np.array(b.positions(points)(case.q))
    velocity = np.array(b.velocities(points)(case.q, case.qd))
    qvel, J = case.motion[1][0], np.zeros((3, case.m.nv))
    for k, (body, place) in enumerate(case.world_points()):
        mujoco.mj_jac(case.m, case.d, J, None, place, body)
        np.testing.assert_allclose(position[:, k], place, atol=1e-12)
        np.testing.assert_allclose(velocity[:, k], J @ qvel, atol=1e-9)


def test_rates_of_points_are_derivatives_of_their_places(case):
    b, points = case.body, tuple(replace(p, radius=0.0) for p in case.points)
    q, qd = (ca.SX.sym(n, b.nv) for n in ("q", "qd"))
    rate = ca.Function("rate", [q, qd], [ca.jtimes(ca.vec(b.positions(points)(q)), q, qd)])
    close(ca.vec(b.velocities(points)(case.q, case.qd)), rate(case.q, case.qd))


@pytest.mark.parametrize("loaded", [False, True])
def test_inverse_dynamics(case, loaded):
    tau = case.d.qfrc_inverse.copy()
    points = case.points if loaded else ()
    forces = (case.forces,) if loaded else ()
    if loaded:
        explained = np.zeros(case.m.nv)
        for force, (body, place) in zip(case.forces.T, case.world_points(), strict=True):
            mujoco.mj_applyFT(case.m, case.d, force, np.zeros(3), place, body, explained)
        tau -= explained
    force, moment = tau[:3], case.d.xmat[1].reshape(3, 3) @ tau[3:6]
    about_com = moment + np.cross(case.d.xpos[1] - case.d.subtree_com[1], force)
    ours = {
        root: np.array(case.body.inverse_dynamics(points, root=root)(*case.state, *forces)).ravel()
        for root in ROOTS
    }
    close(ours["pelvis"], [*force, *moment, *tau[6:]])
    close(ours["com"], [*force, *about_com, *tau[6:]])
    close(ours["coordinates"][3:], [*(OPENSIM_TO_WORLD.T @ force), *tau[6:]])
    assert ours["coordinates"] @ case.qd == pytest.approx(tau @ case.motion[1][0], rel=1e-9)


def wrench_at_com(body):
    """Return a function that gives the residual at the root, about the centre of mass."""
    return lambda *state: np.array(body.inverse_dynamics(root="com")(*state)).ravel()[:6]


def test_coordinate_forces_are_opensims(case):
    _, theirs = opensim_moments(case.motion[0], inverse_dynamics(case.human, *case.motion))
    close(case.body.inverse_dynamics(root="coordinates")(*case.state), theirs[0])


def test_the_body_as_one(case):
    whole = centroid(case.human, *case.motion, ground=-0.3)
    close(case.body.com()(case.q), whole.com[0])
    linear, angular = case.body.momentum()(case.q, case.qd)
    close(linear, case.body.mass * whole.com_vel[0])
    close(angular, whole.angular_momentum[0])
    wrench = wrench_at_com(case.body)(*case.state)
    close(wrench, [*whole.force[0], *whole.moment[0]])


def test_wrench_is_the_rate_of_momentum(case):
    b = case.body
    q, qd, qdd = (ca.SX.sym(n, b.nv) for n in ("q", "qd", "qdd"))
    momentum = ca.vertcat(*b.momentum()(q, qd))
    rate = ca.jtimes(momentum, q, qd) + ca.jtimes(momentum, qd, qdd)
    rate = np.array(ca.Function("rate", [q, qd, qdd], [rate])(*case.state)).ravel()
    rate[:3] -= b.mass * b.gravity
    close(wrench_at_com(b)(*case.state), rate)


def test_any_posture_of_the_pelvis_has_a_world_wrench(case):
    """Where tilt and rotation coincide, the wrench is that of MuJoCo all the same."""
    q = case.q.copy()
    q[1] = np.pi / 2
    qpos, qvel, qacc = case.body.to_mujoco(*(x[None] for x in (q, case.qd, case.qdd)))
    whole = centroid(case.human, qpos, qvel, qacc)
    wrench = wrench_at_com(case.body)(q, case.qd, case.qdd)
    assert whole.force is not None and whole.moment is not None
    close(wrench, [*whole.force[0], *whole.moment[0]])


def test_functions_are_kept_and_small():
    """A 43-coordinate body by plain recursion is about 4150 instructions; here it is fewer."""
    body = SymbolicHuman(person("43", "two-segment"))
    assert body.inverse_dynamics() is body.inverse_dynamics()
    assert body.inverse_dynamics() is not body.inverse_dynamics(contact_sites(body.human))
    assert body.inverse_dynamics().n_instructions() < 4150


def test_bodies_whose_axes_are_turned():
    """No person has such a body yet; the recursion holds for it all the same."""
    human = person("42", "two-segment")
    xml = human.xml.replace('name="tibia_r"', 'name="tibia_r" quat="0.8 0.36 0 -0.48"')
    xml = xml.replace('name="humerus_l"', 'name="humerus_l" quat="0.6 0 0.8 0"')
    case = Case(replace(human, xml=xml))
    test_frames(case)
    test_points(case)
    test_inverse_dynamics(case, True)
    test_the_body_as_one(case)


def test_what_is_refused():
    human = person("42", "two-segment")
    body = SymbolicHuman(human)
    with pytest.raises(CoordinateNotFound, match="no body 'tail'"):
        body.positions([Point("tail")])
    with pytest.raises(ParameterError, match="one of pelvis, com, coordinates"):
        body.inverse_dynamics(root="world")
    with pytest.raises(ParameterError, match="three finite numbers"):
        Point("head", (0.0, float("nan"), 0.0))
    with pytest.raises(ParameterError, match="radius=-0.01"):
        Point("head", radius=-0.01)
    springy = human.xml.replace('name="knee_angle_r"', 'name="knee_angle_r" stiffness="3"')
    with pytest.raises(ParameterError, match="springs, dampers or armature"):
        SymbolicHuman(replace(human, xml=springy))


def test_casadi_loads_when_it_is_needed_only():
    code = "import sys, plantigrade.dynamics.symbolic; assert 'casadi' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("joints, feet", BODIES[:3])
def test_functions_of_a_body_do_not_depend_on_which_was_made_first(joints, feet):
    """They share expressions."""
    case = Case(person(joints, feet))
    makers = (
        lambda body: body.positions(case.points)(case.q),
        lambda body: body.velocities(case.points[3:])(case.q, case.qd),
        lambda body: body.com()(case.q),
        lambda body: body.momentum()(case.q, case.qd)[1],
        lambda body: body.angular_velocities()(case.q, case.qd),
        lambda body: body.inverse_dynamics(case.points)(*case.state, case.forces),
        lambda body: body.frames()(case.q)[1],
    )
    one, other = SymbolicHuman(case.human), SymbolicHuman(case.human)
    forward = [np.array(make(one)) for make in makers]
    backward = [np.array(make(other)) for make in reversed(makers)]
    for a, b in zip(forward, reversed(backward), strict=True):
        np.testing.assert_array_equal(a, b)
