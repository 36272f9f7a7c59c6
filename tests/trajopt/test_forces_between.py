"""Contact forces between nodes: they explain the motion where the ground can, and stay real."""

from functools import cache

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.centroid import without_constraints
from plantigrade.trajopt import ContactBody
from plantigrade.trajopt.transcription.forces_between import explaining, remainder
from tests.models.presets import person

MU = 0.8


@cache
def body() -> ContactBody:
    human = person("42", "two-segment")
    return ContactBody(human, foot_sites(human))


def quiet(n: int) -> np.ndarray:
    """Coordinates of quiet standing, n times; a bent trunk brings the weight over the feet."""
    b = body()
    standing = b.human.standing()
    standing[7 + b.human.hinge("lumbar_extension")] = -0.2
    zero = np.zeros((1, b.symbolic.nv))
    return np.tile(b.symbolic.from_mujoco(standing[None], zero, zero)[0], (n, 1))


def swaying(n: int, seed: int, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """People who nearly stand, and shake a little."""
    rng = np.random.default_rng(seed)
    nv = body().symbolic.nv
    q = quiet(n) + 0.02 * rng.normal(size=(n, nv))
    return q, 0.1 * rng.normal(size=(n, nv)), size * rng.normal(size=(n, nv))


def shared(n: int) -> np.ndarray:
    """ContactBody weight on all sites alike [N]."""
    force = np.zeros((n, len(body().sites), 3))
    force[:, :, 2] = body().weight / len(body().sites)
    return force


def unexplained(q, v, a, force) -> np.ndarray:
    """Force and moment at the root that MuJoCo finds nothing for [body weights, m]."""
    b = body()
    m = without_constraints(b.human)
    d = mujoco.MjData(m)
    out = []
    for qpos, qvel, qacc, f in zip(*b.symbolic.to_mujoco(q, v, a), force, strict=True):
        d.qpos, d.qvel = qpos, qvel
        mujoco.mj_forward(m, d)
        d.qacc = qacc
        mujoco.mj_inverse(m, d)
        tau = d.qfrc_inverse.copy()
        for one, site in zip(f, b.sites, strict=True):
            i = b.human.body(site.body)
            low = d.xpos[i] + d.xmat[i].reshape(3, 3) @ np.array(site.position)
            low = low - [0, 0, site.radius]
            explained = np.zeros(m.nv)
            mujoco.mj_applyFT(m, d, one, np.zeros(3), low, i, explained)
            tau -= explained
        out.append(np.linalg.norm(tau[:6].reshape(2, 3), axis=1).max() / b.weight)
    return np.array(out)


def real(force: np.ndarray, mu: float = MU) -> None:
    """Assert that nothing pulls and nothing leaves the friction cone."""
    weight = body().weight
    assert force[..., 2].min() >= -1e-6 * weight
    side = np.hypot(force[..., 0], force[..., 1])
    assert (side - mu * force[..., 2]).max() < 1e-6 * weight


def test_forces_explain_a_motion_the_ground_can_give():
    q, v, a = swaying(6, 0, 0.15)
    standing = np.ones((6, len(body().sites)), bool)
    before = shared(6)
    after = explaining(body(), q, v, a, before, standing)
    assert remainder(body(), q, v, a, before).min() > 1e-3  # it is not what stands there already
    assert remainder(body(), q, v, a, after).max() < 1e-5
    assert unexplained(q, v, a, after).max() < 1e-5
    real(after)


def test_the_remainder_is_what_mujoco_misses():
    q, v, a = swaying(4, 1, 1.0)
    force = shared(4) * np.random.default_rng(2).uniform(0.5, 1.5, (4, 1, 1))
    np.testing.assert_allclose(remainder(body(), q, v, a, force), unexplained(q, v, a, force))


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 8.0), st.sampled_from([0.3, 0.8]))
@settings(max_examples=12, deadline=None)
def test_no_force_pulls_or_slips_for_any_wrench(seed, size, mu):
    q, v, a = swaying(3, seed, size)
    rng = np.random.default_rng(seed)
    standing = rng.random((3, len(body().sites))) < 0.6
    force = shared(3) * standing[:, :, None]
    after = explaining(body(), q, v, a, force, standing, mu)
    real(after, mu)
    assert not after[~standing].any()


def test_what_the_ground_cannot_give_stays_and_the_least_of_it():
    """Free fall upside down: somebody is pulled to the ground by 0.5 g more than gravity does."""
    q, v, a = quiet(1), np.zeros((1, body().symbolic.nv)), np.zeros((1, body().symbolic.nv))
    a[0, body().symbolic.names.index("pelvis_ty")] = -1.5 * 9.81
    standing = np.ones((1, len(body().sites)), bool)
    after = explaining(body(), q, v, a, shared(1), standing)
    real(after)
    assert np.abs(after).max() < 1e-3 * body().weight
    assert remainder(body(), q, v, a, after)[0] == pytest.approx(0.5, abs=0.02)


def test_in_flight_nothing_pushes():
    q, v, a = swaying(3, 5, 1.0)
    nothing = np.zeros((3, len(body().sites), 3))
    after = explaining(body(), q, v, a, nothing, np.zeros(nothing.shape[:2], bool))
    assert not after.any()


def test_places_that_carry_nothing_are_left_alone_where_others_can_do_it():
    q, v, a = swaying(4, 7, 0.02)
    toes = np.array([s.part == "toe" for s in body().sites])
    force = shared(4)
    force[:, toes] = 0.0
    force *= len(toes) / (~toes).sum()
    after = explaining(body(), q, v, a, force, np.ones(force.shape[:2], bool))
    assert remainder(body(), q, v, a, after).max() < 1e-5
    assert not after[:, toes].any()
    assert np.abs(after - force)[:, ~toes].max() > 1.0


def test_a_body_without_places_has_no_forces():
    bare = ContactBody(person("42", "two-segment"), ())
    q, v, a = swaying(2, 0, 0.1)
    none = np.zeros((2, 0, 3))
    assert explaining(bare, q, v, a, none, np.zeros((2, 0), bool)).shape == (2, 0, 3)
