"""The page on ordered tasks runs as printed, and the movements on it are what it says they are."""

import re
from pathlib import Path

import numpy as np
import pytest

from plantigrade.kinematics.state import BodyState, sweep
from tests.paste import blocks, run_code

PAGE = Path(__file__).resolve().parents[1] / "docs" / "ordered-tasks.md"


@pytest.fixture(scope="module")
def page():
    """Every name the page defines, after all its code has run from top to bottom."""
    return run_code(PAGE)


def path_of(page, motion):
    """Soles (n, k, 3) and centre of mass (n, 3) of a movement."""
    both = [(s.position(page["soles"]), s.com) for s in sweep(page["human"], motion.qpos)]
    soles, com = zip(*both, strict=True)
    return np.array(soles), np.array(com)


@pytest.mark.parametrize("name", ["motion", "squat"])
def test_feet_stay_and_the_centre_of_mass_stays_over_them(page, name):
    soles, com = path_of(page, page[name])
    assert np.linalg.norm(soles - soles[0], axis=2).max() < 2e-3
    low, high = soles[0, :, :2].min(axis=0), soles[0, :, :2].max(axis=0)
    assert (com[:, :2] > low).all() and (com[:, :2] < high).all()
    assert np.abs(com[:, :2] - com[0, :2]).max() < 5e-3


@pytest.mark.parametrize("name", ["motion", "squat"])
def test_joints_stay_within_their_ranges(page, name):
    low, high = page["human"].limits
    hinges = page[name].qpos[:, 7:]
    assert (hinges > low - 2e-3).all() and (hinges < high + 2e-3).all()


def test_the_hand_arrives_and_had_far_to_go(page):
    human, motion = page["human"], page["motion"]
    palm, target = page["palm"], page["target"]
    first, last = (BodyState(human, motion.qpos[k]).position(palm)[0] for k in (0, -1))
    assert np.linalg.norm(last - target) < 0.01
    assert np.linalg.norm(first - target) > 0.5
    np.testing.assert_allclose(motion.qpos[0], page["standing"], atol=0.02)  # no jump at the start


def test_hips_go_back_when_the_hand_goes_forward(page):
    assert page["motion"].qpos[-1, 0] < page["standing"][0] - 0.01


def test_the_squat_goes_down_and_comes_up_alike_on_both_sides(page):
    human, squat = page["human"], page["squat"]
    _, com = path_of(page, squat)
    assert com[0, 2] - com[:, 2].min() == pytest.approx(0.30, abs=0.01)
    assert com[-1, 2] == pytest.approx(com[0, 2], abs=0.01)
    knees = [squat.qpos[:, 7 + human.hinge(f"knee_angle_{side}")] for side in ("r", "l")]
    assert np.rad2deg(knees[0].max()) > 60
    np.testing.assert_allclose(knees[0], knees[1], atol=0.02)


def test_the_head_of_the_walk_is_level_and_the_walk_is_the_same(page):
    """Tasks added below a gait's levels do not change them."""
    from plantigrade.wbc import move

    gait, known = page["gait"], page["known"]
    start = gait.at(gait.start), gait.velocity_at(gait.start)
    plain = move(gait.human, known, *start, start=gait.start, stop=gait.stop)
    assert np.median(page["tilt"]) < 2.0
    com = [
        [BodyState(gait.human, q).com for q in motion.qpos] for motion in (plain, page["walking"])
    ]
    np.testing.assert_allclose(com[0], com[1], atol=3e-3)


def test_a_task_of_ones_own_takes_twenty_lines():
    (block,) = [b for b in blocks(PAGE, "python") if "class Reach" in b]
    lines = [line for line in block.splitlines() if line.strip() and '"""' not in line]
    assert len(lines) <= 20


def test_its_jacobian_and_bias_acceleration_are_rates(page):
    import mujoco

    human, rng = page["human"], np.random.default_rng(0)
    task = page["Reach"](page["palm"], page["target"])
    q, v, h = page["motion"].qpos[200], rng.normal(size=human.model.nv), 1e-5
    states = []
    for way in (-h, h):
        there = q.copy()
        mujoco.mj_integratePos(human.model, there, v, way)
        states.append(BodyState(human, there, v))
    here = BodyState(human, q, v)
    rate = (task.error(states[1], 0.0) - task.error(states[0], 0.0)) / (2 * h)
    np.testing.assert_allclose(task.jacobian(here, 0.0) @ v, rate, atol=1e-7)
    speed = [task.jacobian(s, 0.0) @ v for s in states]
    rate = (speed[1] - speed[0]) / (2 * h)
    np.testing.assert_allclose(task.bias_acceleration(here, 0.0), rate, atol=1e-5)


def test_its_pictures_are_there():
    for target in re.findall(r"\]\((images/[^)]+)\)", PAGE.read_text("utf-8")):
        assert (PAGE.parent / target).is_file(), target
