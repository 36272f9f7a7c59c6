"""Rows of the default formulation against MuJoCo and what rigid bodies allow."""

from functools import cache

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plantigrade import ContactPlan
from plantigrade.contact.plan import Footprint, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.centroid import without_constraints
from plantigrade.dynamics.passive import linear_stiffness, passive_moments, scale
from plantigrade.errors import ParameterError
from plantigrade.trajopt import ContactBody, ProblemBuilder
from plantigrade.trajopt.problem.contact import (
    friction_pyramid,
    hold_contacts,
    site_places,
    site_targets,
)
from plantigrade.trajopt.problem.dynamics import dynamics
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.transcription.derivatives import derivatives_of
from tests.models.presets import person

FEET = {"rigid": "42", "two-segment": "42", "multi-segment": "66"}


@cache
def body_with(feet: str, passive: bool = True) -> ContactBody:
    human = person(FEET[feet], feet)
    return ContactBody(human, foot_sites(human), passive=passive)


class State:
    """MuJoCo in a state given in coordinates."""

    def __init__(self, body: ContactBody, q, v, a=None):
        human = body.human
        a = np.zeros_like(v) if a is None else a
        self.qpos, self.qvel, self.qacc = (
            x[0] for x in body.symbolic.to_mujoco(q[None], v[None], a[None])
        )
        self.m = without_constraints(human)
        self.d = mujoco.MjData(self.m)
        self.d.qpos, self.d.qvel = self.qpos, self.qvel
        mujoco.mj_forward(self.m, self.d)
        self.d.qacc = self.qacc
        mujoco.mj_inverse(self.m, self.d)

    def rotation(self, human, body: str) -> np.ndarray:
        return self.d.xmat[human.body(body)].reshape(3, 3)

    def lowest(self, human, point) -> np.ndarray:
        """The lowest point of a sphere [m]."""
        b = human.body(point.body)
        centre = self.d.xpos[b] + self.d.xmat[b].reshape(3, 3) @ np.array(point.position)
        return centre - [0.0, 0.0, point.radius]

    def material(self, human, point) -> tuple[np.ndarray, np.ndarray]:
        """Velocity of the material at the lowest point of a sphere, and of the body's turning."""
        J, R = np.zeros((3, self.m.nv)), np.zeros((3, self.m.nv))
        mujoco.mj_jac(self.m, self.d, J, R, self.lowest(human, point), human.body(point.body))
        return J @ self.qvel, R @ self.qvel


def at(rows, q, v, a=None, u=None) -> np.ndarray:
    """Rows at one node."""
    a = np.zeros_like(v) if a is None else a
    u = np.zeros(rows.function.size1_in(3)) if u is None else u
    return np.array(rows.function(q, v, a, u, rows.parameters[0])).ravel()


def sagittal(body: ContactBody, rng) -> tuple[np.ndarray, np.ndarray]:
    """A person whose feet pitch and nothing else, and how fast: their other axes are oblique."""
    names = body.symbolic.names
    q, v = np.zeros((2, len(names)))
    for i, name in enumerate(names):
        if name.startswith(("pelvis_tilt", "hip_flexion")):
            q[i], v[i] = rng.uniform(-0.6, 0.6), rng.normal()
        if name in ("pelvis_tx", "pelvis_ty"):
            q[i], v[i] = rng.normal(size=2)
    return q, v


@pytest.mark.parametrize("feet", FEET)
def test_a_pitching_foot_rolls_on_its_spheres(feet):
    """The rate of a place row is the velocity of the material at the lowest point."""
    body = body_with(feet)
    rows = site_places(body, np.zeros((1, len(body.sites))), rates=True)
    for seed in range(5):
        q, v = sagittal(body, np.random.default_rng(seed))
        state, speed = State(body, q, v), at(rows, q, v)
        for k, site in enumerate(body.sites):
            material, omega = state.material(body.human, site)
            np.testing.assert_allclose(speed[3 * k : 3 * k + 3], material, atol=1e-9)
            assert np.abs(omega[[0, 2]]).max() < 1e-9


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_a_foot_that_tilts_as_well_rolls_but_for_the_cosine_of_its_pitch(seed):
    """In any state: exactly while it is level, with an error of second order otherwise."""
    body = body_with("two-segment")
    rng = np.random.default_rng(seed)
    nv = body.symbolic.nv
    q, v = rng.uniform(-0.4, 0.4, nv), rng.normal(size=nv)
    state = State(body, q, v)
    directions, pitches = [], []
    for site in body.sites:
        R = state.rotation(body.human, site.body)
        directions.append(np.arctan2(R[1, 0], R[0, 0]))
        pitches.append(np.arcsin(R[2, 0]))
    speed = at(site_places(body, np.array([directions]), rates=True), q, v)
    for k, site in enumerate(body.sites):
        material, omega = state.material(body.human, site)
        off = np.abs(speed[3 * k : 3 * k + 3] - material)
        most = site.radius * np.linalg.norm(omega) * (1 / np.cos(pitches[k]) - 1)
        assert np.linalg.norm(off[:2]) <= most + 1e-9
        assert off[2] < 1e-9


@pytest.mark.parametrize("feet", FEET)
def test_rates_are_those_of_the_places(feet):
    body = body_with(feet)
    rng = np.random.default_rng(3)
    nv, towards = body.symbolic.nv, rng.uniform(-1, 1, (1, len(body.sites)))
    q, v, h = rng.uniform(-0.3, 0.3, nv), rng.normal(size=nv), 1e-6
    place, speed = (site_places(body, towards, rates=r) for r in (False, True))
    rate = (at(place, q + h * v, v) - at(place, q - h * v, v)) / (2 * h)
    np.testing.assert_allclose(at(speed, q, v), rate, atol=1e-7)


def test_heights_are_those_of_the_lowest_points():
    body = body_with("multi-segment")
    rng = np.random.default_rng(4)
    q = rng.uniform(-0.4, 0.4, body.symbolic.nv)
    state = State(body, q, 0 * q)
    rows = at(site_places(body, np.zeros((1, len(body.sites))), rates=False), q, 0 * q)
    lowest = [state.lowest(body.human, s)[2] for s in body.sites]
    np.testing.assert_allclose(rows[2::3], lowest, atol=1e-12)


# What stands --------------------------------------------------------------------------------------


def stance(heading: float, *, strike: float = 0.0) -> tuple[ContactPlan, np.ndarray]:
    """One step of the right foot, and a node in each of its phases and at each change [s]."""
    foot = Footprint("r", (0.3, -0.1, 0.0), heading)
    plan = ContactPlan(3.0, (Stance(foot, 0.5, 1.0, 1.5, 2.0, 2.5),))
    return plan, np.array([0.2, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.8])


def held(body: ContactBody, heading: float):
    """Rows of places and of speeds of one step, and its nodes."""
    plan, nodes = stance(heading)
    towards = np.full((len(nodes), len(body.sites)), heading)
    place, speed = (site_places(body, towards, rates=r) for r in (False, True))
    hold_contacts(body, plan, nodes, place, speed)
    return plan, nodes, place, speed


def still_rank(body: ContactBody, heading: float, parts: tuple[str, ...]) -> int:
    """How many motions of a standing person parts of the right foot on the ground stop.

    From MuJoCo's Jacobians of the material at the lowest points; all of it shall be at rest.
    """
    human = body.human
    symbolic = body.symbolic
    zero = np.zeros((1, symbolic.nv))
    q = symbolic.from_mujoco(human.standing()[None], zero, zero)[0][0]
    q[symbolic.names.index("pelvis_rotation")] += heading
    state = State(body, q, 0 * q)
    stacked = []
    for site in body.sites:
        if site.side == "r" and site.part in parts:
            J, low = np.zeros((3, state.m.nv)), state.lowest(human, site)
            mujoco.mj_jac(state.m, state.d, J, None, low, human.body(site.body))
            stacked.append(J)
    return int(np.linalg.matrix_rank(np.vstack(stacked), tol=1e-4))


@pytest.mark.parametrize("heading", [0.0, 0.3, np.pi / 2, -2.2])
@pytest.mark.parametrize("feet", FEET)
def test_as_many_rows_are_fixed_as_motions_are_stopped(feet, heading):
    """On the heel, on the flat foot and on the toes, whichever way the foot points."""
    body = body_with(feet)
    _, nodes, place, speed = held(body, heading)
    flat = ("heel", "sole", "ball", "toe")
    phases = {0.2: (), 0.75: ("heel",), 1.25: flat, 1.75: ("ball", "toe"), 2.25: ("toe",), 2.8: ()}
    for time, parts in phases.items():
        i = int(np.argmin(np.abs(nodes - time)))
        there = {s.part for s in body.sites if s.part in parts}
        fixed = np.flatnonzero(place.equations[i])
        expected = still_rank(body, heading, parts) if there else 0
        assert len(fixed) == expected
        assert not speed.equations[i].any()
        if len(fixed):  # and they stop them well
            assert smallest(body, heading, fixed) > 1e-3
    counts = {"rigid": (5, 6, 5), "two-segment": (5, 7, 5), "multi-segment": (5, 18, 10)}
    n = place.equations.sum(axis=1)
    assert (n[2], n[4], n[8]) == counts[feet]  # a heel that rolls leaves one motion of six


def smallest(body: ContactBody, heading: float, fixed: np.ndarray) -> float:
    """The smallest singular value of fixed rows in quiet standing."""
    symbolic = body.symbolic
    zero = np.zeros((1, symbolic.nv))
    q = symbolic.from_mujoco(body.human.standing()[None], zero, zero)[0]
    q[0, symbolic.names.index("pelvis_rotation")] += heading
    rows = site_places(body, np.full((1, len(body.sites)), heading), rates=False)
    u = np.zeros((1, 3 * len(body.sites)))
    J = derivatives_of(rows.function).jacobian(q, zero, zero, u, rows.parameters)[1][0]
    return float(np.linalg.svd(J[fixed, : symbolic.nv], compute_uv=False)[-1])


@pytest.mark.parametrize("feet", FEET)
def test_what_touches_or_leaves_is_at_rest_then(feet):
    """At a change the rows that begin or end are at rest; those that go on are only held."""
    body = body_with(feet)
    _, nodes, place, speed = held(body, 0.0)
    n = place.equations.sum(axis=1), speed.equations.sum(axis=1)
    changes = {0.5: 0.75, 1.0: 1.25, 1.5: 1.25, 2.0: 1.75, 2.5: 2.25}
    for time, most in changes.items():
        i, j = (int(np.argmin(np.abs(nodes - t))) for t in (time, most))
        assert n[0][i] == n[0][j]  # first and last instant included
        assert n[1][i] == n[0][j] - min(n[0][i - 1], n[0][i + 1])
        assert not (speed.equations[i] & ~place.equations[i]).any()


@pytest.mark.parametrize("heading", [0.0, 1.2])
def test_a_foot_is_held_on_its_footprint_and_above_the_ground_elsewhere(heading):
    body = body_with("two-segment")
    plan, _, place, _ = held(body, heading)
    foot = plan.stances[0].footprint
    targets = site_targets(body, foot)
    towards = np.array([np.cos(heading), np.sin(heading)])
    heel, toe = (
        np.mean([targets[s.name] for s in body.sites if s.side == "r" and s.part == p], axis=0)
        for p in ("heel", "toe")
    )
    ahead = (toe - heel)[:2] @ towards
    assert ahead > 0.18 and np.linalg.norm((toe - heel)[:2]) == pytest.approx(ahead, rel=0.1)
    assert abs((heel[:2] - foot.position[:2]) @ towards) < 0.08  # the ankle is above the footprint
    fixed = place.equations[4]
    for row in np.flatnonzero(fixed):
        name = body.sites[row // 3].name
        assert place.lower[4, row] == pytest.approx(targets[name][row % 3])
    heights = np.arange(2, 3 * len(body.sites), 3)
    np.testing.assert_array_equal(place.lower[0, heights], 0.0)
    assert np.isinf(place.upper[0]).all()


# Forces and torques -------------------------------------------------------------------------------


@pytest.mark.parametrize("feet", FEET)
@pytest.mark.parametrize("passive", [False, True])
def test_dynamics_are_mujocos(feet, passive):
    """Random states and forces: what is missing at the root, and what muscles do and work."""
    body = body_with(feet, passive)
    human, names = body.human, body.symbolic.names
    family = dynamics(body, 1)
    parts = {part.name: part for part in family.parts}
    assert family.function.size1_out(0) == len(family.names)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        q, v, a = rng.uniform(-0.5, 0.5, len(names)), *rng.normal(size=(2, len(names)))
        u = rng.normal(size=3 * len(body.sites))
        state = State(body, q, v, a)
        tau = state.d.qfrc_inverse.copy()
        for force, site in zip(u.reshape(-1, 3) * body.weight, body.sites, strict=True):
            explained, zero = np.zeros(state.m.nv), np.zeros(3)
            low, b = state.lowest(human, site), human.body(site.body)
            mujoco.mj_applyFT(state.m, state.d, force, zero, low, b, explained)
            tau -= explained
        found = {name: at(part, q, v, a, u) for name, part in parts.items()}
        moment = state.rotation(human, "pelvis") @ tau[3:6]
        np.testing.assert_allclose(found["root force"], tau[:3] / body.weight, atol=1e-9)
        np.testing.assert_allclose(found["root moment"], moment / body.weight, atol=1e-9)
        together = np.concatenate(list(found.values()))
        np.testing.assert_allclose(at(family, q, v, a, u), together, atol=1e-12)
        muscle = tau[6:]
        if passive:
            factor = scale(human.mass, human.height)
            muscle = muscle - np.array(passive_moments(names[6:], q[6:], v[6:], factor))
        np.testing.assert_allclose(found["muscle torque"] * body.torque, muscle, atol=1e-7)
        power, work = muscle * v[6:] / body.torque, found["work rate"]
        for name, whole in zip(body.stiff, found["joint torque"], strict=True):
            assert whole * body.torque == pytest.approx(tau[names.index(name)], abs=1e-7)
        assert (work <= np.abs(power) + 1e-9).all() and (work >= np.abs(power) - 0.5).all()
    for name, part in parts.items():
        assert part.equations.all() if name.startswith("root") else not part.equations.any()


def test_the_trunk_is_limited_with_its_tissue():
    """Tissue holds a bent trunk, too: muscles alone kept a limit that both together broke."""
    body = body_with("rigid")
    human, reserve = body.human, Limits().reserve
    strength = np.abs(human.model.jnt_actfrcrange[1:]).min(axis=1)
    stiffness = linear_stiffness(human.coordinates)
    for i, name in enumerate(human.coordinates):
        if name.startswith(("lumbar", "thorax")):
            tissue = stiffness[i] * np.abs(human.limits[:, i]).max()
            assert name in body.stiff or tissue <= reserve * strength[i]


def test_what_limits_a_part_limits_the_whole():
    whole = dynamics(body_with("rigid"), 2)
    work = next(part for part in whole.parts if part.name == "work rate")
    work.upper[1, 3] = 7.0
    assert (whole.upper == 7.0).sum() == 1
    assert whole.names[int(np.flatnonzero(whole.upper[1] == 7.0)[0])] == work.names[3]


def test_force_in_the_pyramid_is_in_the_cone():
    body = body_with("rigid")
    n, mu = len(body.sites), 0.6
    rows = friction_pyramid(body, 1, mu)
    rng = np.random.default_rng(0)
    zero = np.zeros(body.symbolic.nv)
    u = rng.normal(size=(400, n, 3)) * [0.4, 0.4, 1.0]
    kept = np.array([at(rows, zero, zero, u=x.ravel()).reshape(n, 4) >= 0 for x in u]).all(axis=2)
    assert 0.05 < kept.mean() < 0.9
    inside = u[kept]
    assert (inside[:, 2] >= 0).all()
    assert (np.hypot(inside[:, 0], inside[:, 1]) <= mu * inside[:, 2] + 1e-12).all()
    straight = np.tile([0.0, 0.0, 1.0], n)
    pushed = straight + np.tile([mu / np.sqrt(2) * 0.999, 0.0, 0.0], n)
    assert (at(rows, zero, zero, u=pushed) > 0).all()


@pytest.mark.parametrize("slope", [0.0, 0.15, -0.3])
def test_on_a_slope_gravity_leans(slope):
    """A person at rest is held upwards in the world, which leans in the axes of the ground."""
    human = person("42", "rigid")
    plan = ContactPlan(1.0, (), slope=slope)
    body = ContactBody(human, foot_sites(human), plan=plan)
    rows = dynamics(body, 1)
    zero = np.zeros(body.symbolic.nv)
    force = at(rows.parts[0], zero, zero)
    np.testing.assert_allclose(force, [np.sin(slope), 0.0, np.cos(slope)], atol=1e-9)
    np.testing.assert_allclose(plan.to_world @ force, [0.0, 0.0, 1.0], atol=1e-9)
    assert plan.to_world[2, 0] == pytest.approx(np.sin(slope))  # x goes up
    assert body.weight == pytest.approx(human.mass * 9.81, rel=1e-3)


def test_rows_of_the_motion_are_the_motion():
    body = body_with("rigid")
    q, v, a = np.random.default_rng(1).normal(size=(3, body.symbolic.nv))
    builder = ProblemBuilder(body, ContactPlan(1.0, ()), np.array([0.0, 1.0]))
    for what, expected in (("coordinates", q), ("speeds", v), ("accelerations", a)):
        rows = builder.family(what)
        np.testing.assert_array_equal(at(rows, q, v, a), expected)
        assert len(rows.names) == len(expected)


def test_a_body_of_other_tissue_shares_no_rows():
    body = body_with("rigid")
    other = body_with("rigid", passive=False)
    assert dynamics(other, 1).function is not dynamics(body, 1).function
    assert dynamics(body, 1).function is dynamics(body, 1).function


def test_a_node_is_at_the_requested_time_or_missing():
    nodes = np.array([0.0, 0.4, 1.0])
    builder = ProblemBuilder(body_with("rigid"), ContactPlan(1.0, ()), nodes)
    assert builder.node(0.4) == 1
    for time in (0.41, 1.2):
        with pytest.raises(ParameterError, match="no node at"):
            builder.node(time)


def test_a_heel_that_has_risen_does_not_sink_into_its_tread():
    """Walking down: until the toes have left, the whole foot is above the ground it stands on."""
    body = body_with("two-segment")
    up, down = Footprint("r", (0.0, -0.1, 0.0)), Footprint("l", (0.6, 0.1, -0.12))
    plan = ContactPlan(
        3.0, (Stance(up, 0.0, 0.1, 1.0, 1.2, 1.5), Stance(down, 1.4, 1.6, 3.0, 3.0, 3.0))
    )
    nodes = np.linspace(0.0, 3.0, 31)
    towards = np.zeros((31, len(body.sites)))
    place, speed = (site_places(body, towards, rates=r) for r in (False, True))
    hold_contacts(body, plan, nodes, place, speed)
    right, left = ([3 * k + 2 for k, s in enumerate(body.sites) if s.side == side] for side in "rl")
    standing, swinging = nodes <= 1.5, nodes > 1.55
    low = np.where(np.isinf(place.lower), np.nan, place.lower)  # followers need no limit
    assert np.nanmin(low[standing][:, right]) == 0.0
    np.testing.assert_array_equal(low[swinging][:, right], -0.12)
    assert np.nanmax(low[nodes < 1.4][:, left]) == -0.12
