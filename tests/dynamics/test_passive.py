"""Moments of tissue: published curves, signs, and who is heavier."""

import numpy as np
import pytest

from plantigrade.dynamics.passive import (
    DAMPING,
    IN_SERIES,
    STIFFNESS,
    linear_stiffness,
    passive_moments,
    sagittal_springs,
    scale,
)
from plantigrade.models.coordinates import REFERENCE_HEIGHT, REFERENCE_MASS
from tests.models.presets import PRESETS, person

LEG = ("hip_flexion_r", "knee_angle_r", "ankle_angle_r")


def of_leg(hip: float, knee: float, ankle: float, rates=(0.0, 0.0, 0.0), factor: float = 1.0):
    """Moments of hip, knee and ankle [N m] at angles in degrees, flexion and dorsiflexion."""
    q = np.deg2rad([hip, knee, ankle])
    return np.array(passive_moments(LEG, q, np.array(rates), factor), dtype=float)


@pytest.mark.parametrize(
    ("angles", "moments"),
    [
        # hip 4.3297 - 3.8202 + 8.072; knee 6.0496 - 0.0189 - 4.820 + 9.2073; ankle 0.0003 - 8.1792
        ((0.0, 0.0, 0.0), (8.5815, 10.4181, -8.1789 + 1.792)),
        # bent hip over a bent knee: e^(1.4655 - 0.34 - 3.75) - e^(1.3403 - 2.26 + 1.525) + 8.072
        ((50.0, 100.0, 0.0), (0.0725 - 1.8318 + 8.072, None, None)),
        # knee 30: e^0.744 - e^-2.486 - 4.820 + e^-2.28
        ((0.0, 30.0, 0.0), (None, 2.1043 - 0.0832 - 4.820 + 0.1023, None)),
        # ankle 20 up: e^-11.8743 - e^3.7876 + 1.792; ankle 30 down: e^-2.1293 - e^-0.4274 + 1.792
        ((0.0, 0.0, 20.0), (None, None, -44.150 + 1.792)),
        ((0.0, 0.0, -30.0), (None, None, 0.1189 - 0.6522 + 1.792)),
    ],
)
def test_the_published_curves(angles, moments):
    """Computed by hand from Eqs. 1 to 3 of Riener and Edrich (1999)."""
    found = of_leg(*angles)
    for one, expected in zip(found, moments, strict=True):
        if expected is not None:
            assert one == pytest.approx(expected, abs=2e-3)


def test_ends_of_ranges_are_pushed_back_from():
    assert of_leg(110, 60, 0)[0] < -20  # a hip bent far is stretched
    assert of_leg(-20, 0, 0)[0] > 10  # and one stretched far is bent
    assert of_leg(0, -5, 0)[1] > 10  # a knee that overextends is bent
    assert of_leg(0, 140, 0)[1] < -15
    assert of_leg(0, 0, 25)[2] < -30  # toes pulled up are let down
    assert of_leg(0, 0, -50)[2] > 1.5


def test_muscles_over_two_joints_couple_them():
    """A stretched calf bends the knee; hamstrings let a hip bend further over a bent knee."""
    assert of_leg(0, 20, 20)[1] > of_leg(0, 20, 0)[1]
    assert (
        of_leg(0, 0, 15)[2] < of_leg(0, 60, 15)[2]
    )  # the calf is tight where the knee is straight
    assert of_leg(90, 0, 0)[0] < of_leg(90, 60, 0)[0]  # so are the hamstrings


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_every_joint_is_pulled_back_and_slowed(preset):
    """Farther from the middle no moment grows outwards; speed only ever takes energy."""
    human = person(*preset)
    names = human.coordinates
    low, high = human.limits
    rng = np.random.default_rng(0)
    middle, still = (low + high) / 2, np.zeros(len(names))
    for i, name in enumerate(names):
        near, far = middle.copy(), middle.copy()
        near[i], far[i] = middle[i] - 0.2 * (high - low)[i], middle[i] + 0.2 * (high - low)[i]
        one, other = (passive_moments(names, q, still)[i] for q in (near, far))
        assert other <= one + 1e-9, name
        if linear_stiffness(names)[i]:
            assert other < one
    q, v = rng.uniform(low, high), rng.normal(size=len(names))
    moving, resting = (np.array(passive_moments(names, q, x)) for x in (v, still))
    np.testing.assert_array_less((moving - resting) * v, 0.0)
    slowed = -(moving - resting) / v
    assert set(np.round(slowed, 9)) <= set(DAMPING.values())


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_a_spine_in_more_parts_is_not_softer(preset):
    """The middle part of a trunk in three had no stiffness; one in two had that of one, halved."""
    names = person(*preset).coordinates
    stiffness = dict(zip(names, linear_stiffness(names), strict=True))
    for whole, joints in IN_SERIES.items():
        for way in ("extension", "bending", "rotation"):
            parts = [k for name, k in stiffness.items() if name in {f"{j}_{way}" for j in joints}]
            assert 1 / sum(1 / k for k in parts) == pytest.approx(STIFFNESS[f"{whole}_{way}"])
    slowed = -np.array(passive_moments(names, np.zeros(len(names)), np.ones(len(names))))
    slowed += np.array(passive_moments(names, np.zeros(len(names)), np.zeros(len(names))))
    trunk = [i for i, n in enumerate(names) if n.rpartition("_")[0] in IN_SERIES["trunk"]]
    assert set(np.round(slowed[trunk], 9)) == {DAMPING["lumbar"]}


def test_sides_are_alike():
    human = person("42", "two-segment")
    names = human.coordinates
    q = np.zeros(len(names))
    for i, name in enumerate(names):
        if name.endswith(("_r", "_l")):
            q[i] = 0.1 + 0.02 * (sum(map(ord, name[:-2])) % 7)
    found = dict(zip(names, passive_moments(names, q, 0 * q), strict=True))
    for name, moment in found.items():
        if name.endswith("_r"):
            assert moment == pytest.approx(found[name[:-2] + "_l"])


def test_moments_go_with_mass_times_height():
    assert scale(REFERENCE_MASS, REFERENCE_HEIGHT) == pytest.approx(1.0)
    factor = scale(2 * REFERENCE_MASS, REFERENCE_HEIGHT / 2)
    assert factor == pytest.approx(1.0)
    assert scale(100.0, 2.0) == pytest.approx(2 * scale(50.0, 2.0))
    rates = (0.3, -1.0, 2.0)
    np.testing.assert_allclose(
        of_leg(30, 40, 10, rates, 1.7), 1.7 * of_leg(30, 40, 10, rates), rtol=1e-12
    )


def test_symbols_and_numbers_agree():
    ca = pytest.importorskip("casadi")
    names = person("42", "two-segment").coordinates
    rng = np.random.default_rng(1)
    q, v = rng.uniform(-0.5, 0.5, (2, len(names)))
    x, y = ca.SX.sym("q", len(names)), ca.SX.sym("v", len(names))
    made = ca.Function("moments", [x, y], [ca.vertcat(*passive_moments(names, x, y, 0.8))])
    found = np.array(made(q, v)).ravel()
    np.testing.assert_allclose(found, np.array(passive_moments(names, q, v, 0.8)), rtol=1e-12)


def test_springs_of_the_leg_are_its_moments_and_their_slopes():
    rng = np.random.default_rng(0)
    angles = np.deg2rad(rng.uniform([[-10], [0], [-30]], [[90], [110], [20]], (3, 4)))
    moments, stiffness = sagittal_springs(angles, 1.3)
    assert (stiffness > 0).all()
    small = 1e-6
    for i, (q, m, k) in enumerate(zip(angles.T, moments.T, stiffness.T, strict=True)):
        for j in range(3):
            moved = [np.array(passive_moments(LEG, q + s * np.eye(3)[j], np.zeros(3), 1.3))
                     for s in (-small, 0.0, small)]  # fmt: skip
            assert moved[1][j] == pytest.approx(m[j]), (i, j)
            assert (moved[0][j] - moved[2][j]) / (2 * small) == pytest.approx(k[j], rel=1e-4)
