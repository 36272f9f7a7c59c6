"""The foot pose controller: marked segments lie on the ground, whatever is asked of the ankle."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.contact.relief import Bump, HeightField
from plantigrade.contact.site import contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.foot_pose import (
    HEEL_EDGE,
    MARKS,
    SEGMENTS,
    FootPoser,
    marks,
)
from plantigrade.kinematics.ground_normal import smallest_turn
from plantigrade.kinematics.state import BodyState, PointSet
from tests.models.presets import person

TOES = ("medial_phalanges", "lateral_phalanges")
LATERAL_SIDE = ("heel", "lateral_metatarsal", "lateral_phalanges")
TOUCHES = 5e-5  # [m]
BODY = person("66", "multi-segment")
POSERS = {side: FootPoser(BODY, side) for side in "rl"}
LEVEL = Ground()


def pose(side, height, names, facing=None, ground=None, at=(0.0, 0.0)):
    """Pose one foot, its ankle at a height above the ground's zero."""
    facing = np.eye(3) if facing is None else facing
    ankle = np.array([[*at, height]])
    return POSERS[side].pose(ankle, facing[None], marks(*names)[None], ground)


def on_marked(side, found, names):
    """Clearance of the spheres of marked segments [m]."""
    index = [SEGMENTS.index(name) for name in names if name in SEGMENTS]
    return found.clearance[:, np.isin(POSERS[side].segment, index)]


def aloft(side, found, names):
    index = [SEGMENTS.index(name) for name in names if name in SEGMENTS]
    return found.clearance[:, ~np.isin(POSERS[side].segment, index)]


def pitch(found):
    """Angle of the foot's forward axis below the horizontal [rad]."""
    return float(-np.arcsin(found.rotation[0, 2, 0]))


@pytest.mark.parametrize("side", "rl")
class TestPosesOfThePaper:
    def test_rest(self, side):
        found = pose(side, POSERS[side].standing, SEGMENTS)
        assert np.abs(found.clearance).max() < TOUCHES
        assert np.abs(found.angles).max() < 1e-9 and abs(found.shift[0]) < 1e-9

    def test_tiptoe_puts_all_ten_points_of_the_toes_on_the_ground(self, side):
        found = pose(side, 0.11, TOES)
        down = on_marked(side, found, TOES)
        assert down.shape[1] == 10 and np.abs(down).max() < TOUCHES
        assert aloft(side, found, TOES).min() > 0.01
        assert pitch(found) > np.deg2rad(15) and found.shift[0] == pytest.approx(0, abs=1e-12)

    @pytest.mark.parametrize("names", [LATERAL_SIDE, ("heel", "medial_phalanges")])
    def test_a_lower_ankle_tilts_the_foot_and_lifts_its_other_side(self, side, names):
        found = pose(side, POSERS[side].standing - 0.002, names)
        assert np.abs(on_marked(side, found, names)).max() < TOUCHES
        assert aloft(side, found, names).min() > 0.002
        outside = np.arcsin(found.rotation[0, 2, 1]) * (1 if side == "l" else -1)
        assert (outside < -0.1) if names == LATERAL_SIDE else (outside > 0.1)

    @pytest.mark.parametrize("names", [SEGMENTS, TOES])
    def test_slope(self, side, names):
        ground = Ground(slope=np.deg2rad(10), height=0.03)
        height = (0.03 + (0.1 if names == TOES else POSERS[side].standing)) / np.cos(ground.slope)
        found = pose(side, height, names, ground=ground)
        assert np.abs(on_marked(side, found, names)).max() < TOUCHES
        assert abs(found.shift[0]) < 1e-9

    def test_edge_of_the_heel(self, side):
        found = pose(side, POSERS[side].standing + 0.01, (HEEL_EDGE,))
        heel = found.clearance[0, POSERS[side].segment == SEGMENTS.index("heel")]
        assert heel.min() == pytest.approx(0, abs=TOUCHES) and heel.max() > 0.005
        assert pitch(found) < -0.1 and np.abs(found.angles).max() == 0.0


def test_the_turn_is_that_of_equations_1_and_2():
    poser, height, n = POSERS["r"], 0.1, np.array([0.0, 0.0, 1.0])
    facing = Rotation.from_euler("ZYX", [0.4, 0.2, 0.1]).as_matrix()
    joint = next(b for b in BODY.skeleton.bodies if b.name == "medial_phalanges_r").position
    radius = BODY.model.geom(poser.spheres[-1]).size[0]
    v = facing @ joint
    axis = np.cross(n, v) / np.linalg.norm(np.cross(n, v))
    now = np.arctan2(np.linalg.norm(v - (v @ n) * n), -v @ n)
    angle = now - np.arccos((height - radius) / np.linalg.norm(v))
    found = pose("r", height, ("medial_phalanges",), facing)
    expected = Rotation.from_rotvec(angle * axis).as_matrix() @ facing
    np.testing.assert_allclose(found.rotation[0], expected, atol=1e-12)


def test_the_hinges_put_the_spheres_where_the_pose_says():
    ground = Ground(bumps=(Bump((0.06, 0.02, -0.49), 0.5),))
    for side, poser in POSERS.items():
        found = pose(side, 0.10, TOES, Rotation.from_euler("z", 0.3).as_matrix(), ground)
        q = BODY.standing()
        q[[7 + BODY.hinge(c) for c in poser.coordinates]] = found.angles[0]
        state, sites = BodyState(BODY, q), [s for s in contact_sites(BODY) if s.side == side]
        local = state.position(PointSet.of(BODY, sites)) - state.origin(f"foot_{side}")
        local = local @ state.rotation(f"foot_{side}")
        world = local @ found.rotation[0].T + [0, 0, 0.10 + found.shift[0]]
        gap = (world[:, 2] - ground.under(world)) * ground.normal_at(world)[:, 2]
        order = [poser.spheres.index(f"contact_{s.name}") for s in sites]
        radius = np.array([s.radius for s in sites])
        np.testing.assert_allclose(found.clearance[0, order], gap - radius, atol=1e-12)


@pytest.mark.parametrize("radius", [1.0, 0.5])
def test_a_foot_on_a_sphere_bends_to_it(radius):
    ground = Ground(height=-0.1, bumps=(Bump((0.05, 0.0, -radius), radius),))
    found = pose("l", POSERS["l"].standing, SEGMENTS, ground=ground)
    assert found.clearance.min() > -2e-4 and found.clearance.max() < 0.002
    stiff = pose("l", POSERS["l"].standing + found.shift[0], (), ground=ground)
    assert np.ptp(stiff.clearance) > 0.006


def test_steps_and_relief_are_ground_too():
    relief = HeightField((-0.3, -0.3), (0.6, 0.3), ((0.0, 0.06), (0.0, 0.06), (0.0, 0.06)))
    found = pose("r", 0.11, SEGMENTS, ground=Ground(field=relief))
    assert np.abs(found.clearance).max() < TOUCHES  # a ramp is a plane
    stair = Ground(steps=(GroundStep(-1.0, 0.15),))
    found = pose("r", 0.15 + POSERS["r"].standing, SEGMENTS, ground=stair)
    assert np.abs(found.clearance).max() < TOUCHES and abs(found.shift[0]) < 1e-9


def turns(largest):
    angle = st.floats(-largest, largest)
    return st.tuples(st.floats(-3.1, 3.1), angle, angle).map(
        lambda a: Rotation.from_euler("ZYX", a).as_matrix()
    )


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from("rl"),
    st.floats(0.07, 0.14),
    turns(0.7),
    st.sampled_from([TOES, TOES[:1], TOES[1:]]),
    st.floats(-0.2, 0.2),
)
def test_every_ankle_within_reach_has_its_toes_flat(side, height, facing, names, slope):
    found = pose(side, height, names, facing, Ground(slope=slope))
    assert abs(found.shift[0]) < 1e-9
    assert np.abs(on_marked(side, found, names)).max() < TOUCHES
    assert not found.undetermined[0]
    np.testing.assert_allclose(found.rotation[0] @ found.rotation[0].T, np.eye(3), atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from("rl"),
    st.floats(-0.5, 1.0),
    turns(3.1),
    st.lists(st.sampled_from(SEGMENTS), unique=True, min_size=1),
)
def test_out_of_reach_the_ankle_is_moved_and_the_pose_is_that_of_the_moved_one(
    side, height, facing, names
):
    found = pose(side, height, names, facing)
    for value in (found.rotation, found.angles, found.shift, found.clearance):
        assert np.isfinite(value).all()
    np.testing.assert_allclose(np.linalg.det(found.rotation), 1.0)
    again = pose(side, height + found.shift[0], names, found.rotation[0])
    assert abs(again.shift[0]) < 1e-7
    hanging = set(names) >= {"medial_phalanges", "lateral_phalanges"}
    hanging &= "lateral_metatarsal" not in names  # the cuboid joint may not reach that far
    if not hanging:
        assert np.abs(on_marked(side, found, names)).max() < TOUCHES


def test_the_smallest_turn_takes_one_direction_to_the_other_even_if_it_is_half_a_turn():
    rng = np.random.default_rng(0)
    c = rng.normal(size=(300, 3))
    c /= np.linalg.norm(c, axis=1)[:, None]
    d = -c + 10.0 ** rng.uniform(-12, 0.5, (300, 1)) * rng.normal(size=(300, 3))
    d[0] = -c[0]
    d /= np.linalg.norm(d, axis=1)[:, None]
    turn, half = smallest_turn(c, d)
    np.testing.assert_allclose((turn @ c[..., None])[..., 0], d, atol=1e-12)
    np.testing.assert_allclose(
        turn @ turn.swapaxes(1, 2), np.tile(np.eye(3), (300, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(turn), 1.0)
    angle = np.arccos(np.clip((c * d).sum(axis=1), -1, 1))
    np.testing.assert_allclose(Rotation.from_matrix(turn).magnitude(), angle, atol=1e-5)
    assert half[0] and not half[angle < 3.1].any()


def test_frames_are_posed_one_by_one():
    rng = np.random.default_rng(0)
    ankle = rng.uniform(0.05, 0.14, (30, 3))
    facing = Rotation.random(30, random_state=1).as_matrix()
    marked = rng.random((30, len(MARKS))) < 0.5
    whole = POSERS["r"].pose(ankle, facing, marked)
    for i in range(30):
        one = POSERS["r"].pose(ankle[i : i + 1], facing[i : i + 1], marked[i : i + 1])
        np.testing.assert_allclose(one.rotation[0], whole.rotation[i], atol=1e-7)
        np.testing.assert_allclose(one.angles[0], whole.angles[i], atol=1e-7)
        np.testing.assert_allclose(one.clearance[0], whole.clearance[i], atol=1e-7)


def test_a_foot_straight_below_its_ankle_and_half_turns_are_resolved_with_a_note():
    joint = next(b for b in BODY.skeleton.bodies if b.name == "heel_r").position
    below = joint / np.linalg.norm(joint)
    down = Rotation.align_vectors([[0, 0, -1.0]], [below])[0].as_matrix()
    found = pose("r", POSERS["r"].standing - 0.005, ("heel",), down)
    assert found.undetermined[0]
    assert np.abs(on_marked("r", found, ("heel",))).max() < TOUCHES
    upside_down = np.diag([1.0, -1.0, -1.0])
    found = pose("r", POSERS["r"].standing, SEGMENTS, upside_down)
    assert found.undetermined[0] and np.abs(found.clearance).max() < TOUCHES
    on_end = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    found = pose("r", 0.12, TOES, on_end)
    assert found.undetermined[0] and np.isfinite(found.angles).all()


def test_nothing_marked_leaves_the_foot_as_it_faces():
    facing = Rotation.from_euler("ZYX", [1.0, 0.5, 0.2]).as_matrix()
    found = pose("l", 0.4, (), facing)
    np.testing.assert_array_equal(found.rotation[0], facing)
    assert not found.angles.any() and not found.shift.any()


def test_soles_count():
    shod = BODY.with_soles({name: -0.012 for name, side, _ in BODY.contact_points if side == "r"})
    poser = FootPoser(shod, "r")
    assert poser.standing == pytest.approx(POSERS["r"].standing + 0.012)
    ankle = np.array([[0.0, 0.0, poser.standing]])
    found = poser.pose(ankle, np.eye(3)[None], marks(*SEGMENTS)[None])
    assert np.abs(found.clearance).max() < TOUCHES and np.abs(found.angles).max() < 1e-9


def test_what_is_no_foot_or_no_mark_is_refused():
    with pytest.raises(ParameterError, match="rigid feet"):
        FootPoser(person("42", "rigid"), "r")
    with pytest.raises(ParameterError, match="no segment ball; there are heel"):
        marks("ball")
    with pytest.raises(ParameterError, match="finite"):
        pose("r", np.nan, SEGMENTS)
    with pytest.raises(ParameterError, match="3 columns"):
        POSERS["r"].pose(np.zeros((1, 3)), np.eye(3)[None], np.zeros((1, 3), bool))
