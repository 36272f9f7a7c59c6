"""Ground that is given for a recording is put below the feet; what is not given is suggested."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.contact.ground import Ground
from plantigrade.errors import FitError, ParameterError
from plantigrade.io import read
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.given_ground import below_feet, suggested
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.kinematics.textbook_recording import recorded, textbook_walk
from plantigrade.models import Human
from plantigrade.trajopt.guess.walk import walking_guess
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters
from plantigrade.trajopt.tasks.walking_plan import walk_plan
from plantigrade.workflows.fit import given_ground
from plantigrade.workflows.settings import FitSettings

RATE = 100.0


def on_slope(qpos, degrees):
    """The motion turned about the y axis, as level ground would be that rises by so much."""
    up = Rotation.from_euler("y", -degrees, degrees=True)
    turned = np.array(qpos)
    turned[:, :3] = up.apply(qpos[:, :3])
    quat = up * Rotation.from_quat(qpos[:, [4, 5, 6, 3]])
    turned[:, 3:7] = quat.as_quat()[:, [3, 0, 1, 2]]
    return turned


@pytest.fixture(scope="module")
def walk():
    return textbook_walk(Human.create(1.74, 71.0))


@pytest.fixture(scope="module")
def climb():
    """A walk up two steps of 15 cm and down one: person, time, motion."""
    human = Human.create(1.74, 71.0)
    p = gait_parameters(human, 0.9)
    plan = walk_plan(human, p, steps=7, heights=(0.0, 0.15, 0.30, 0.30, 0.15, 0.15, 0.15))
    time = np.arange(0.0, plan.duration, 1 / RATE)
    return (
        human,
        time,
        human.from_coordinates((*PELVIS, *human.coordinates), walking_guess(human, plan, p, time)),
    )


PELVIS = ("pelvis_tilt", "pelvis_list", "pelvis_rotation", "pelvis_tx", "pelvis_ty", "pelvis_tz")


@pytest.mark.parametrize("degrees", [-10.0, 4.0, 12.0])
def test_a_slope_is_recognised_and_found(walk, degrees):
    """Also where it lies 20 cm above the origin of the laboratory, along the normal."""
    qpos, ground = on_slope(walk.qpos, degrees), Ground(slope=np.deg2rad(degrees))
    qpos[:, :3] += 0.2 * ground.normal
    assert suggested(walk.human, walk.time, qpos).startswith(f"--ground slope:{degrees:g}")
    found = below_feet(ground, walk.human, walk.time, qpos)
    assert found.slope == ground.slope and found.height == pytest.approx(0.2, abs=0.005)
    soles = sole_paths(walk.human, qpos, found)
    level = sole_paths(walk.human, walk.qpos)
    np.testing.assert_allclose(soles.position[..., :2], level.position[..., :2], atol=1e-9)
    assert find_rests(soles, RATE) == find_rests(level, RATE)


def test_level_ground_suggests_nothing(walk):
    assert suggested(walk.human, walk.time, walk.qpos) == ""
    assert suggested(walk.human, walk.time, on_slope(walk.qpos, 1.0)) == ""


def test_standing_on_tiptoe_suggests_nothing():
    """Heels and balls rest, but ever farther apart: the balls stay on the ground."""
    human = Human.create(1.74, 71.0)
    time, qpos = np.arange(0.0, 4.0, 1 / RATE), []
    ankle = [7 + human.hinge(f"ankle_angle_{side}") for side in "rl"]
    for second, angle in enumerate(np.deg2rad([0.0, -15.0, -30.0, -20.0])):
        pose = human.standing()
        pose[0], pose[ankle] = 0.5 * second, angle
        pose[2] -= sole_paths(human, pose[None]).position[..., 2].min()
        qpos += [pose] * int(RATE)
    assert suggested(human, time, np.array(qpos)) == ""


@pytest.mark.slow
def test_level_belts_suggest_nothing(walk, data):
    """A real one, on which heels rise before they leave: its feet seem to be carried down by 2°."""
    qpos = walk.qpos.copy()
    qpos[:, 0] -= walk.speed * walk.time
    assert suggested(walk.human, walk.time, qpos) == ""
    fit = fit_markers(read(data / "c3d" / "gaitalytics_treadmill_events.c3d"))
    assert suggested(fit.human, fit.time, fit.qpos) == ""


def test_a_belt_that_rises_is_recognised(walk):
    """On it feet stand at one place all the time: what tells is that it carries them down."""
    ground = Ground(slope=np.deg2rad(6.0))
    qpos = on_slope(walk.qpos, 6.0)
    qpos[:, :3] -= walk.speed * walk.time[:, None] * ground.to_world[:, 0]
    assert suggested(walk.human, walk.time, qpos) == "--ground slope:6"
    found = below_feet(ground, walk.human, walk.time, qpos)
    assert found.height == pytest.approx(0.0, abs=0.005)


def test_steps_are_recognised_and_found(climb):
    human, time, qpos = climb
    assert "--ground steps:15" in suggested(human, time, qpos)
    shape = given_ground(FitSettings(ground="steps:15"))
    found = below_feet(shape.shape, human, time, qpos)
    assert found.height == pytest.approx(0.0, abs=0.01)
    np.testing.assert_allclose([s.height for s in found.steps], [0.15, 0.3, 0.15], atol=0.01)
    soles = sole_paths(human, qpos, found).position[..., 2]
    standing = [r for r in find_rests(sole_paths(human, qpos, found), RATE) if r.region == "ball"]
    assert len(standing) >= 6
    assert soles.min() > -0.02, "no foot swings through a step"


def test_a_slope_on_which_the_feet_do_not_stand_is_refused(walk):
    """A level walk said to be on a slope was fitted, and ok."""
    with pytest.raises(FitError, match="not stand on a slope of 20°.*on level ground leave out"):
        below_feet(Ground(slope=np.deg2rad(20)), walk.human, walk.time, walk.qpos)


def test_feet_that_stand_nowhere_do_not_place_the_ground(walk):
    with pytest.raises(FitError, match="stand still . times; 2 are needed to place"):
        below_feet(Ground(slope=0.1), walk.human, walk.time[:20], walk.qpos[40:60])


@pytest.mark.parametrize(
    "word", ["stairs:3", "slope", "slope:8,70", "slope:8,x", "steps:0", "steps:15,10", "flat"]
)
def test_words_that_describe_no_ground_are_refused(word):
    with pytest.raises(ParameterError, match=r"no ground|needs a number"):
        given_ground(FitSettings(ground=word))


@pytest.mark.slow
def test_markers_on_a_slope_are_fitted_as_on_level_ground(walk):
    """The same feet and joint angles, the pelvis turned by the slope; it may rise aside of x."""
    level = recorded(walk, Path("walk.c3d"))
    up = Rotation.from_euler("z", -15.0, degrees=True) * Rotation.from_euler(
        "y", -8.0, degrees=True
    )
    x = level.markers.positions
    turned = up.apply(x.reshape(-1, 3)).reshape(x.shape)
    tilted = replace(level, markers=replace(level.markers, positions=turned))
    one = fit_markers(level)
    two = fit_markers(tilted, ground=given_ground(FitSettings(ground="slope:8,-15")))
    assert two.metrics["marker_rms_mean_mm"] == pytest.approx(
        one.metrics["marker_rms_mean_mm"], abs=0.1
    )
    assert two.ground.slope == pytest.approx(np.deg2rad(8.0))
    apart = np.rad2deg(np.abs(two.qpos[:, 7:] - one.qpos[:, 7:])).max(axis=0)
    assert np.median(apart) < 0.5 and apart.max() < 3.0
    soles = sole_paths(two.human, two.qpos, two.ground).position
    flat = sole_paths(one.human, one.qpos).position
    np.testing.assert_allclose(soles[..., 2], flat[..., 2], atol=0.01)
