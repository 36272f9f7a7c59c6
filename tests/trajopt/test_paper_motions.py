"""The spline paper's motions: settings, conditions, polygons, and a solved one between samples."""

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt.diagnose.violations import values
from plantigrade.trajopt.solvers.sparse_program import SparseProgram
from plantigrade.trajopt.zhakatayev2023 import (
    MOTIONS,
    PaperBody,
    PaperSolution,
    formulate,
    paper_human,
    paper_motion,
)
from plantigrade.trajopt.zhakatayev2023.conditions import SLIP, footholds, standing
from plantigrade.trajopt.zhakatayev2023.formulation import spline
from plantigrade.trajopt.zhakatayev2023.polygons import convex, corners, edges, outside
from plantigrade.trajopt.zhakatayev2023.staged import least_squares


@pytest.fixture(scope="module")
def body() -> PaperBody:
    """A person like the paper's."""
    return PaperBody.of(paper_human())


@pytest.fixture(scope="module")
def side_step() -> PaperSolution:
    """The motion that is solved soonest."""
    return paper_motion(paper_human(), "side-step", "polynomial")


def test_the_body_is_the_papers(body):
    assert body.symbolic.nv == 43
    assert len(body.human.body_names) == 20
    assert body.symbolic.mass == pytest.approx(77.5)
    assert body.human.dimensions.thigh == pytest.approx(0.44, abs=0.002)
    assert np.abs(body.resting[:, 2]).max() < 1e-9  # all twelve points on the ground


def test_variables_and_constraints_are_as_many_as_printed(body):
    for motion in MOTIONS.values():
        for basis in ("trigonometric", "polynomial"):
            n = spline(motion, basis).n_coefficients * body.symbolic.nv
            assert n == motion.printed.variables
    for task in ("sit-to-stand", "side-step"):
        paper = formulate(body, MOTIONS[task])
        assert paper.n_constraints == MOTIONS[task].printed.constraints


def test_sitting_is_hips_knees_and_elbows_at_right_angles_on_flat_feet(body):
    q = body.seated()
    points = np.array(body.symbolic.positions(body.contacts)(q)).T
    np.testing.assert_allclose(points, body.resting, atol=1e-9)
    for name in ("knee_angle_r", "knee_angle_l", "elbow_flex_r"):
        assert np.degrees(q[body.index(name)]) == pytest.approx(90.0)
    assert np.degrees(q[body.index("hip_flexion_r")]) == pytest.approx(90.0, abs=1.0)
    thigh = body.human.dimensions.thigh
    sunk = body.neutral[4] - q[4], body.neutral[3] - q[3]
    np.testing.assert_allclose(sunk, thigh, atol=0.012)


def test_the_walks_feet_take_half_a_step_two_full_ones_and_half_a_step(body):
    motion = MOTIONS["walk"]
    for side, (first, *_, last) in motion.places.items():
        assert tuple(first) == (0.0, 0.0) and last == pytest.approx((1.2, 0.0))
        ahead = motion.places[side][np.array(motion.contact[side]), 0]
        steps = np.diff(ahead)[np.diff(ahead) > 0]
        np.testing.assert_allclose(np.sort(steps), (0.4, 0.8))
    assert standing(motion).sum() == 6 * 12  # what the printed number of constraints asks for
    places = footholds(body, motion)
    np.testing.assert_allclose(places[-1], body.resting + [1.2, 0.0, 0.0])


def rectangle(x: float, y: float, *, left: bool) -> np.ndarray:
    """Return six points of a foot 0.2 m long and 0.1 m wide with its heel at x."""
    inner, outer = (y - 0.05, y + 0.05) if left else (y + 0.05, y - 0.05)
    return np.array([[x + dx, side] for dx in (0.0, 0.15, 0.2) for side in (inner, outer)])


def area(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("in_front", ["r", "l"])
def test_polygons_are_the_papers_three_cases(in_front):
    step = {"r": 0.0, "l": 0.0}
    for step[in_front], kind in ((0.5, "long"), (0.05, "short"), (0.0, "beside")):
        feet = {
            "r": rectangle(step["r"], -0.1, left=False),
            "l": rectangle(step["l"], 0.1, left=True),
        }
        polygon = corners(feet)
        assert len(polygon) == 4 and area(polygon) > 0.0  # counterclockwise
        hull = convex(np.vstack(list(feet.values())))
        assert outside(polygon, hull).max() <= 1e-12  # what the paper allows, physics allows
        middle = np.vstack(list(feet.values())).mean(axis=0, keepdims=True)
        assert outside(middle, polygon)[0] < 0.0
        if kind == "beside":
            assert area(polygon) == pytest.approx(0.3 * 0.2)
            assert area(hull) == pytest.approx(area(polygon))
    alone = corners({"r": rectangle(0.0, 0.0, left=False)})
    assert area(alone) == pytest.approx(0.2 * 0.1)


def test_distance_to_a_polygon():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    points = np.array([[0.5, 0.5], [2.0, 0.5], [2.0, 2.0], [0.9, 0.5]])
    np.testing.assert_allclose(outside(points, square), (-0.5, 1.0, np.sqrt(2.0), -0.1))
    half_planes = edges(square)
    np.testing.assert_allclose(np.linalg.norm(half_planes[:, :2], axis=1), 1.0)


def test_edge_rows_are_the_moment_of_the_weight_about_the_edges(body):
    """Standing at rest, the ground reaction is body weight below the centre of mass."""
    motion = MOTIONS["side-step"]
    paper = formulate(body, motion)
    forces = next(r for r in paper.problem.rows if r.name == "forces")
    rest = np.zeros(43)
    values = np.array(forces.function(body.neutral, rest, rest, [], forces.parameters[0])).ravel()
    com = np.array(body.symbolic.com()(body.neutral)).ravel()
    feet = {s: body.resting[6 * i : 6 * i + 6, :2] for i, s in enumerate("rl")}
    half_planes = edges(corners(feet))
    expected = body.weight * (half_planes[:, :2] @ com[:2] - half_planes[:, 2])
    np.testing.assert_allclose(200.0 * values[43:], expected, rtol=1e-9)
    assert (expected < 0).all()
    assert 200.0 * values[2] == pytest.approx(body.weight)


def test_least_squares_puts_feet_on_their_targets(body):
    paper = formulate(body, MOTIONS["sit-to-stand"], basis="polynomial")
    part = paper.problem.part(("boundary", "places"), costs=False)
    program = SparseProgram(part, paper.guess)
    c, steps, left = least_squares(program, paper.guess)
    assert left < 1e-7 and steps < 20
    q, _, _ = paper.problem.states(c, MOTIONS["sit-to-stand"].times)
    for pose in q:
        points = np.array(body.symbolic.positions(body.contacts)(pose)).T
        np.testing.assert_allclose(points, body.resting, atol=1e-5)


def test_a_solved_motion_keeps_its_conditions_at_its_samples(side_step):
    assert side_step.result.success and side_step.result.violation < 2e-5
    assert [stage.name for stage in side_step.result.stages] == ["bounds", "contact", "all"]
    motion, body = side_step.paper.motion, side_step.paper.body
    q, qd, _ = side_step.paper.problem.states(side_step.result.c, motion.times)
    np.testing.assert_allclose(q[0], body.neutral, atol=1e-9)
    assert q[-1, 5] - q[0, 5] == pytest.approx(0.3)
    np.testing.assert_allclose(qd[[0, -1]], 0.0, atol=1e-9)
    places, stands = footholds(body, motion), standing(motion)
    for k in range(motion.n_samples):
        points = np.array(body.symbolic.positions(body.contacts)(q[k])).T
        np.testing.assert_allclose(points[stands[k]], places[k][stands[k]], atol=2e-5)
        speed = np.array(body.symbolic.velocities(body.contacts)(q[k], qd[k])).T
        assert np.abs(speed[stands[k]]).max() <= SLIP + 2e-5
        assert points[:, 2].min() > -2e-5


def test_what_lies_between_the_samples_is_found_by_another_engine(side_step):
    """MuJoCo's inverse dynamics agree with the rows at the samples; between them faults appear."""
    course, motion = side_step.course, side_step.paper.motion
    at = np.searchsorted(course.times, motion.times - 1e-9)
    problem = side_step.paper.problem
    forces = next(rows for rows in problem.rows if rows.name == "forces")
    states = problem.states(side_step.result.c, problem.nodes)
    found = values(forces, *states, np.zeros((len(problem.nodes), 0))) * 200.0
    np.testing.assert_allclose(course.wrench[at], found[:, :6], atol=1e-5)
    np.testing.assert_allclose(course.torques[at], found[:, 6:43], atol=1e-5)
    assert side_step.between.zmp > 0.05
    assert 0.0 < side_step.between.penetration < 0.1


def test_a_solution_is_a_motion(side_step):
    motion = side_step.motion(50.0)
    assert motion.qpos.shape == (51, 44)
    assert motion.qpos[-1, 1] - motion.qpos[0, 1] == pytest.approx(-0.3)  # to the right
    np.testing.assert_allclose(motion.qvel[[0, -1]], 0.0, atol=1e-9)


def test_what_cannot_be_is_refused(body):
    with pytest.raises(ParameterError, match="no motion 'fly'; it has walk"):
        paper_motion(body.human, "fly")
    with pytest.raises(ParameterError, match="trigonometric, polynomial"):
        formulate(body, MOTIONS["walk"], basis="wavelet")
    with pytest.raises(ParameterError, match="two-segment, not multi-segment"):
        paper_motion(Human.create(joints="66"), "walk")
