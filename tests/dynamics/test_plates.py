"""Whose foot was on which plate, and what each foot felt."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.dynamics.plates import assign_plates, sole_points
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import ForcePlate

RATE, PLATE_RATE = 100.0, 1000.0
STEP, STRIDE = 0.7, 1.1  # length of a step [m], duration of a stride [s]
STANCE = 0.66  # s
SPEED = 2 * STEP / STRIDE
SOLE = np.array(
    [[-0.05, 0.03, 0], [-0.05, -0.03, 0], [0.13, 0.05, 0], [0.13, -0.05, 0], [0.2, 0, 0]]
)


def walk(belt: float = 0.0, duration: float = 3.3):
    """Return frame times and soles of a walker whose right foot lands at t = 0, x = 0.

    A foot stands for 0.66 s and then swings to the next place in a smooth arc. With a belt, the
    walker stays in place and the ground moves backwards.
    """
    t = np.arange(0, duration, 1 / RATE)
    soles = {}
    for side, late, y in (("r", 0.0, -0.1), ("l", STRIDE / 2, 0.1)):
        n = np.floor((t - late) / STRIDE)
        phase = (t - late) - n * STRIDE
        u = np.clip((phase - STANCE) / (STRIDE - STANCE), 0, 1)
        smooth = u**3 * (10 - 15 * u + 6 * u * u)
        x = (n + smooth) * 2 * STEP + (STEP if side == "l" else 0.0)
        height = 0.12 * np.sin(np.pi * u) ** 2
        centre = np.stack([x - belt * t, np.full_like(t, y), height], axis=1)
        soles[side] = centre[:, None] + SOLE
    return t, soles


def reaction(time, start, stop, where, speed=0.0, **kwargs) -> ForcePlate:
    """Return a plate loaded from start to stop by a foot at ``where``, rolling heel to toe."""
    u = np.clip((time - start) / (stop - start), 0, 1)
    on = (time >= start) & (time <= stop)
    up = np.where(on, 800 * np.sin(np.pi * u) ** 0.5, 0.0)
    force = np.stack([-0.15 * up * np.cos(np.pi * u), 0.03 * up, up], axis=1)
    cop = np.array(where) + np.stack([-0.05 + 0.22 * u, 0 * u, 0 * u], axis=1)
    cop[:, 0] += speed * (time - start)
    cop[up < 10] = np.nan
    return ForcePlate("1", time, force, cop, 5 * np.sin(2 * np.pi * u) * on, **kwargs)


def square(x0, x1, y0=-0.3, y1=0.3):
    return np.array([[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]], float)


def both(a: ForcePlate, b: ForcePlate) -> ForcePlate:
    """Return what one plate measures when two wrenches act on it."""
    force = a.force + b.force
    moment = np.zeros_like(force)
    for p in (a, b):
        moment += np.cross(np.nan_to_num(p.cop), p.force) + p.free_moment[:, None] * [0, 0, 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = -moment[:, 1] / force[:, 2], moment[:, 0] / force[:, 2]
    cop = np.stack([x, y, 0 * x], axis=1)
    cop[force[:, 2] < 10] = np.nan
    free = moment[:, 2] - np.nan_to_num(x * force[:, 1] - y * force[:, 0])
    return replace(a, force=force, cop=cop, free_moment=free)


PLATE_TIME = np.arange(0, 3.3, 1 / PLATE_RATE)


def stance(side: str, k: int):
    """Return start, stop and place of stance ``k`` of a side."""
    start = k * STRIDE + (STRIDE / 2 if side == "l" else 0.0)
    x = k * 2 * STEP + (STEP if side == "l" else 0.0)
    return start, start + STANCE, (x, 0.1 if side == "l" else -0.1, 0.0)


def test_two_plates_two_feet():
    t, soles = walk()
    right_one, left_one = (reaction(PLATE_TIME, *stance(s, 1)) for s in "rl")
    f = assign_plates((left_one, replace(right_one, name="2")), t, soles)
    assert [(u.plate, u.side) for u in f.uses] == [("1", "l"), ("2", "r")]
    right = (t > 1.12) & (t < 1.74)
    expected = reaction(t, *stance("r", 1))
    np.testing.assert_allclose(f.force[right, 0], expected.force[right], atol=3)
    np.testing.assert_allclose(f.point[right, 0], expected.cop[right], atol=2e-3)
    np.testing.assert_allclose(f.torque[right, 0, 2], expected.free_moment[right], atol=0.2)
    assert (f.force[~((t >= 1.1) & (t <= 1.77)), 0] == 0).all()
    assert np.isnan(f.point[f.force[..., 2] == 0]).all()
    # Right stance 1 and left stance 1 are measured, the left foot's stance 0 ends at 1.21 s.
    assert f.valid[(t > 1.30) & (t < 2.1)].all()
    assert not f.valid[(t > 1.12) & (t < 1.18)].any()
    assert f.valid_side[(t > 1.12) & (t < 1.76), 0].all()
    assert not f.valid_side[(t > 2.3) & (t < 2.8), 0].any()  # right stance 2 is on the floor
    assert f.beside_plates[0] > 0.2, "right stances 0 and 2 are on the floor"


def test_smoothing_keeps_force_inside_the_contact_and_the_centre_on_the_foot():
    t, soles = walk()
    plate = reaction(PLATE_TIME, *stance("r", 1))
    rng = np.random.default_rng(0)
    noisy = replace(plate, force=plate.force + rng.normal(size=plate.force.shape) * 5)
    f = assign_plates((noisy,), t, soles, cutoff=8.0)
    outside = (t < 1.09) | (t > 1.77)
    assert (f.force[outside] == 0).all()
    on = f.force[:, 0, 2] > 0
    assert f.point[on, 0, 0].min() > 1.4 - 0.10 and f.point[on, 0, 0].max() < 1.4 + 0.23
    middle = (t > 1.2) & (t < 1.66)
    np.testing.assert_allclose(
        f.force[middle, 0], reaction(t, *stance("r", 1)).force[middle], atol=30
    )
    impulse = np.trapezoid(f.force[:, 0, 2], t)
    np.testing.assert_allclose(impulse, np.trapezoid(plate.force[:, 2], PLATE_TIME), rtol=0.02)


def test_one_column_group_holds_one_foot_after_the_other():
    t, soles = walk()
    a, b = reaction(PLATE_TIME, *stance("r", 1)), reaction(PLATE_TIME, *stance("l", 2))
    one = both(a, b)
    f = assign_plates((one,), t, soles)
    assert [u.side for u in f.uses] == ["r", "l"]
    assert f.force[(t > 1.2) & (t < 1.7), 0, 2].min() > 300
    assert f.force[(t > 2.8) & (t < 3.2), 1, 2].min() > 300


def test_both_feet_on_one_plate_are_not_separated():
    t, soles = walk()
    one = both(reaction(PLATE_TIME, *stance("r", 1)), reaction(PLATE_TIME, *stance("l", 1)))
    one = replace(one, corners=square(1.0, 3.0))
    f = assign_plates((one,), t, soles)
    double = (t > 1.68) & (t < 1.74)
    assert not f.valid_side[double].any()
    single = (t > 1.25) & (t < 1.6)
    assert f.valid_side[single, 0].all()
    assert any("both feet" in w for w in f.warnings)
    later = (t > 1.82) & (t < 2.13)
    assert f.valid[later].all()
    assert f.force[later, 1, 2].min() > 300 and (f.force[later, 0] == 0).all()


def test_foot_partly_off_the_plate():
    t, soles = walk()
    start, stop, where = stance("r", 1)
    whole = assign_plates(
        (reaction(PLATE_TIME, start, stop, where, corners=square(1.2, 1.8)),), t, soles
    )
    partly = assign_plates(
        (reaction(PLATE_TIME, start, stop, where, corners=square(1.4, 2.0)),), t, soles
    )
    stands = (t > 1.15) & (t < 1.72)
    assert whole.valid_side[stands, 0].all()
    assert not partly.valid_side[stands, 0].any()
    assert any("partly off" in w for w in partly.warnings)
    assert not any("partly" in w for w in whole.warnings)


def test_side_that_the_file_names_is_believed():
    t, soles = walk()
    plate = reaction(PLATE_TIME, *stance("r", 1), side="l")
    f = assign_plates((plate,), t, soles)
    assert f.uses[0].side == "l"
    # The force under the other foot's sole is not used for either, and said.
    assert (f.force == 0).all() and not f.valid_side[(t > 1.3) & (t < 1.6), 1].any()
    assert "outside the sole of the left foot" in f.uses[0].problem
    right = replace(plate, side="r")
    assert assign_plates((right,), t, soles).force[(t > 1.3) & (t < 1.6), 0, 2].min() > 300


def test_treadmill_with_two_belts():
    t, soles = walk(belt=SPEED)
    plates = []
    for name, side in (("left", "l"), ("right", "r")):
        steps = [
            reaction(
                PLATE_TIME,
                *(stance(side, k)[:2]),
                np.array(stance(side, k)[2]) - [SPEED * stance(side, k)[0], 0, 0],
                -SPEED,
            )
            for k in range(-1, 4)
        ]
        belt = steps[0]
        for step in steps[1:]:
            belt = both(belt, step)
        low, high = (0.0, 0.5) if side == "l" else (-0.5, 0.0)
        plates.append(replace(belt, name=name, corners=square(-1.5, 1.5, low, high)))
    f = assign_plates(tuple(plates), t, soles)
    assert {(u.plate, u.side) for u in f.uses} == {("left", "l"), ("right", "r")}
    assert f.valid[(t > 0.1) & (t < 3.2)].all(), f.warnings
    assert f.warnings == ()
    r = (t > 1.2) & (t < 1.6)
    expected = reaction(t, *stance("r", 1)[:2], (-0.0, -0.1, 0.0), -SPEED)
    np.testing.assert_allclose(f.force[r, 0], expected.force[r], atol=3)
    np.testing.assert_allclose(f.point[r, 0], expected.cop[r], atol=3e-3)


def test_a_foot_across_two_belts_has_what_both_carry():
    t, soles = walk(belt=SPEED)
    across = soles["l"] - [0.0, 0.1, 0.0]  # the left foot lands on the gap
    soles = {"r": soles["r"], "l": across}
    steps = []
    for side, k, y in (("r", 1, -0.1), ("l", 1, 0.0)):
        start, stop, (x, *_) = stance(side, k)
        steps.append(reaction(PLATE_TIME, start, stop, (x - SPEED * start, y, 0.0), -SPEED))
    right, left = steps
    part = replace(left, force=0.15 * left.force, free_moment=0.15 * left.free_moment)
    rest = replace(left, force=0.85 * left.force, free_moment=0.85 * left.free_moment)
    plates = (
        replace(both(right, part), corners=square(-1.5, 1.5, -0.5, 0.0)),
        replace(rest, name="2", corners=square(-1.5, 1.5, 0.0, 0.5)),
    )
    f = assign_plates(plates, t, soles)
    off, down = stance("r", 1)[1], stance("r", 2)[0]
    alone = (t > off + 0.05) & (t < min(down, stance("l", 1)[1]) - 0.1)
    true = reaction(t, *stance("l", 1)[:2], (0.0, 0.0, 0.0), -SPEED)
    assert alone.sum() > 10
    assert (f.force[alone, 0] == 0.0).all()
    np.testing.assert_allclose(f.force[alone, 1], true.force[alone], atol=5)
    assert f.valid[alone].all()
    shared = (t > stance("l", 1)[0] + 0.03) & (t < off - 0.03)
    assert shared.any() and not f.valid_side[shared].any()


def test_an_empty_plate():
    t, soles = walk()
    plate = reaction(PLATE_TIME, 1.1, 1.76, (5.0, 1.0, 0.0))
    f = assign_plates((plate,), t, soles)
    assert f.uses[0].side == "" and (f.force == 0).all()
    assert not f.valid[(t > 1.2) & (t < 1.7)].any()
    assert "no foot" in f.warnings[0]


def test_no_plates_means_unknown_where_a_foot_stands_and_known_in_flight():
    t, soles = walk()
    f = assign_plates((), t, soles)
    assert not f.valid[10:-10].any()
    up = {}
    jump = np.linspace(-1, 1, len(t))
    rise = np.clip(0.4 * (1 - (jump / 0.5) ** 2), 0, None)
    for s in ("r", "l"):
        up[s] = np.zeros((len(t), 1, 3)) + SOLE + rise[:, None, None] * [0, 0, 1]
        up[s][..., 1] += 0.1 if s == "l" else -0.1
    f = assign_plates((), t, up)
    assert f.valid[rise > 0.1].all()
    assert not f.valid[np.abs(jump) > 0.53].any()


def test_a_person_who_hovers_above_the_plates_stands_on_a_box():
    t = np.arange(0.0, 2.0, 1 / RATE)
    fall = np.clip((t - 1.0) / 0.25, 0.0, 1.0)  # off a box of 30 cm
    height = 0.3 * (1.0 - fall**2)
    soles = {
        side: np.stack([0 * t, np.full_like(t, y), height], axis=1)[:, None] + SOLE
        for side, y in (("r", -0.1), ("l", 0.1))
    }
    plates = tuple(reaction(PLATE_TIME[:2000], 1.25, 2.0, (0.1, y, 0.0)) for y in (-0.1, 0.1))
    lift = np.where((t > 1.0) & (t < 1.25), 0.0, 9.81)
    f = assign_plates(plates, t, soles, lift=lift)
    assert not f.valid_side[t < 1.0].any() and f.valid_side[(t > 1.01) & (t < 1.2)].all()
    assert f.beside_plates[0] == f.beside_plates[1] == pytest.approx(0.5, abs=0.02)
    # Without knowing what the motion requires, feet above the plates are in the air.
    assert assign_plates(plates, t, soles).valid_side[t < 0.9].all()


def test_frames_beyond_the_plates_are_not_valid():
    t, soles = walk()
    plate = reaction(PLATE_TIME[:2000], *stance("r", 1))
    f = assign_plates((plate,), t, soles)
    assert not f.valid_side[t > 2.01].any()
    assert any("forces were not measured in " in w for w in f.warnings)


def test_missing_side_is_refused():
    t, soles = walk()
    with pytest.raises(ParameterError, match="lacks side 'l'"):
        assign_plates((), t, {"r": soles["r"]})
    with pytest.raises(ParameterError, match="frames need"):
        assign_plates((), t, soles | {"l": soles["l"][:5]})


def test_measured_walk_against_opensims_inverse_dynamics(data):
    """OpenSim's own inverse dynamics of this trial, made with its 22-body model."""
    mot = pytest.importorskip("plantigrade.io.mot")
    folder = data / "opensim" / "rajagopal_walk"
    coordinates = mot.read_mot(folder / "coordinates.sto").coordinates
    plates = mot.read_mot(folder / "grf_walk.mot").plates
    theirs = mot.read_table(folder / "id_walk.sto")
    # Lengths between the joints of the scaled model the angles belong to.
    human = Human.create(1.80, 85.27, feet="rigid", lengths={"thigh": 0.4030, "shank": 0.4653})
    t = coordinates.time
    d = differentiate(human, t, human.from_coordinates(coordinates.names, coordinates.values), None)
    forces = assign_plates(plates, t, sole_points(human, d.qpos))
    assert forces.valid.all() and {u.side for u in forces.uses} == {"r", "l"}
    m = inverse_dynamics(human, d.qpos, d.qvel, d.qacc, forces)
    inside = slice(50, -50)  # their filter bends the ends
    for side in ("r", "l"):
        for name, least in (("hip_flexion", 0.97), ("knee_angle", 0.97), ("ankle_angle", 0.99)):
            a, b = m[f"{name}_{side}"][inside], theirs[f"{name}_{side}_moment"][inside]
            assert np.corrcoef(a, b)[0, 1] > least
        # a and b are the ankle's; hip and knee peaks hang on where the hip centre is taken to be
        assert abs(np.abs(a).max() / np.abs(b).max() - 1) < 0.1
    assert np.abs(m.residual_force[inside]).max() < 0.1 * human.mass * 9.81
