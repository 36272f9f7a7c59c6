"""The person as one compiled model: counts, masses, stature, symmetry, and standing."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.models import FEET, JOINT_SETS, Dimensions, Human
from plantigrade.models.coordinates import coordinate_of
from plantigrade.spatial.conventions import PELVIS
from tests.models.presets import (
    PRESETS,
    SEXES,
    mirrored,
    other_side,
    person,
    random_state,
    velocity_mirror,
)

FOOT_COUNTS = {"rigid": (0, 0), "two-segment": (1, 1), "multi-segment": (12, 4)}
NATIVE = {"42": (42, 19), "43": (43, 20), "58": (58, 25), "66": (66, 21)}


@pytest.fixture(params=PRESETS, ids="-".join)
def human(request):
    return person(*request.param)


@pytest.fixture(params=[(*p, s) for p in PRESETS for s in SEXES], ids="-".join)
def sexed(request):
    return person(*request.param)


def standing(human):
    data = mujoco.MjData(human.model)
    data.qpos = human.standing()
    mujoco.mj_forward(human.model, data)
    return data


def contact_spheres(human):
    return [i for i in range(human.model.ngeom) if human.model.geom_group[i] == 3]


@pytest.mark.parametrize("joints", JOINT_SETS)
def test_the_papers_counts_with_the_native_foot(joints):
    human = Human.create(joints=joints)
    assert (human.model.nv, human.model.nbody - 1) == NATIVE[joints]
    assert int(joints) == human.model.nv


@pytest.mark.parametrize(("joints", "feet"), PRESETS)
def test_another_foot_changes_the_count_by_its_own(joints, feet):
    rigid = person(joints, "rigid").model
    model = person(joints, feet).model
    coordinates, segments = FOOT_COUNTS[feet]
    assert model.nv == rigid.nv + 2 * coordinates
    assert model.nbody == rigid.nbody + 2 * segments


def test_distribution_of_the_42_coordinates():
    """8 per arm, 7 per leg, 3 lower back, 3 neck, 6 pelvis; 19 segments."""
    names = Human.create(joints="42").coordinates
    arm = ("arm_", "elbow_", "pro_", "wrist_", "fingers_")
    leg = ("hip_", "knee_", "ankle_", "subtalar_", "mtp_")
    for side in ("_r", "_l"):
        assert sum(n.startswith(arm) and n.endswith(side) for n in names) == 8
        assert sum(n.startswith(leg) and n.endswith(side) for n in names) == 7
    assert sum(n.startswith("lumbar_") for n in names) == 3
    assert sum(n.startswith("neck_") for n in names) == 3


def test_mass_and_stature_are_exact(sexed):
    assert sexed.model.body_mass.sum() == pytest.approx(71.0, rel=1e-12)
    data, head = standing(sexed), sexed.body("head")
    top = [
        data.geom_xpos[g, 2] + sexed.model.geom_size[g, 2]
        for g in range(sexed.model.ngeom)
        if sexed.model.geom_bodyid[g] == head
        and sexed.model.geom_type[g] == mujoco.mjtGeom.mjGEOM_ELLIPSOID
    ]
    assert max(top) == pytest.approx(1.74, abs=1e-9)


def test_the_feet_rest_on_the_ground_below_the_centre_of_mass(sexed):
    data, model = standing(sexed), sexed.model
    spheres = contact_spheres(sexed)
    bottom = data.geom_xpos[spheres, 2] - model.geom_size[spheres, 0]
    np.testing.assert_allclose(bottom, 0, atol=1e-12)
    hull = ConvexHull(data.geom_xpos[spheres, :2])
    distance = hull.equations[:, :2] @ data.subtree_com[1, :2] + hull.equations[:, 2]
    assert distance.max() < -0.035  # metres inside the support


@pytest.mark.parametrize("sex", SEXES)
def test_the_centre_of_mass_lies_over_the_hips(sex):
    """Zero to three centimetres behind the hip joints, as in quiet standing, and not ahead."""
    human = Human.create(1.7, 70.0, sex)
    data = standing(human)
    ahead = data.subtree_com[1, 0] - data.xpos[human.body("femur_r"), 0]
    assert -0.03 < ahead < 0.0


def test_the_centre_of_mass_is_at_the_published_height(sexed):
    """55-57 % of stature in standing adults."""
    assert 0.55 < standing(sexed).subtree_com[1, 2] / sexed.height < 0.57


def test_inertias_are_physical(sexed):
    """No principal moment exceeds the sum of the two others; all are positive."""
    moments = np.sort(sexed.model.body_inertia[1:], axis=1)
    assert (moments > 0).all()
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1]).all()


def test_standing_is_within_the_joint_ranges(human):
    low, high = human.limits
    q = human.standing()[7:]
    assert ((low < q) & (q < high)).all()
    assert (low < high).all()
    np.testing.assert_array_equal(human.model.jnt_range[1:].T, human.limits)


def test_strength_is_written_to_the_model_and_grows_with_mass_and_height(human):
    names = human.coordinates
    limits = human.model.jnt_actfrcrange[1:]
    assert human.model.jnt_actfrclimited[1:].all()
    assert (limits[:, 0] < 0).all() and (limits[:, 1] > 0).all()
    double = Human.create(1.74, 142.0, "male", human.joints, human.feet).model
    np.testing.assert_allclose(double.jnt_actfrcrange[1:], 2 * limits)
    for i, name in enumerate(names):
        np.testing.assert_array_equal(limits[i], limits[names.index(other_side(name))])


def test_left_and_right_are_mirror_images(human):
    """Positions, the mass matrix and gravity of a mirrored state."""
    rng = np.random.default_rng(5)
    q, v = random_state(human, rng)
    P = velocity_mirror(human)
    one, other = mujoco.MjData(human.model), mujoco.MjData(human.model)
    one.qpos, one.qvel = q, v
    other.qpos, other.qvel = mirrored(human, q), P @ v
    for data in (one, other):
        mujoco.mj_forward(human.model, data)
    for name in human.body_names:
        a, b = human.body(name), human.body(other_side(name))
        np.testing.assert_allclose(one.xpos[a] * [1, -1, 1], other.xpos[b], atol=1e-12)
        np.testing.assert_allclose(one.xipos[a] * [1, -1, 1], other.xipos[b], atol=1e-12)
    M = [np.zeros((human.model.nv,) * 2) for _ in range(2)]
    mujoco.mj_fullM(human.model, one, M[0])
    mujoco.mj_fullM(human.model, other, M[1])
    np.testing.assert_allclose(M[1], P @ M[0] @ P.T, atol=1e-10)
    np.testing.assert_allclose(other.qfrc_bias, P @ one.qfrc_bias, atol=1e-9)


def test_the_person_stands_for_a_second_and_the_ground_carries_the_weight(human):
    """Stiff joint springs hold the posture.

    The trunk is bent forward a little so that the weight is over the middle of the foot, where
    people carry it, and not over the joint of the multi-segment heel.
    """
    spec = mujoco.MjSpec.from_string(human.xml)
    spec.option.timestep = 5e-4
    model = spec.compile()
    data = mujoco.MjData(model)
    posture = human.standing()
    posture[7 + human.hinge("lumbar_extension")] = -0.2
    data.qpos = posture
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    inertia = np.diag(M)[6:]
    stiff = np.minimum(2000.0, 0.2 * inertia / spec.option.timestep**2)
    model.jnt_stiffness[1:] = stiff
    model.qpos_spring[7:] = posture[7:]
    model.dof_damping[6:] = 2 * np.sqrt(stiff * inertia)
    start = data.subtree_com[1].copy()
    vertical = []
    for step in range(2000):
        mujoco.mj_step(model, data)
        if step >= 1000:
            vertical.append(_ground_force(model, data))
    weight = 71.0 * 9.81
    assert np.mean(vertical) == pytest.approx(weight, rel=0.01)
    assert np.linalg.norm(data.subtree_com[1] - start) < 0.03
    assert data.xmat[1].reshape(3, 3)[2, 2] > 0.998


def _ground_force(model, data):
    total, force = 0.0, np.zeros(6)
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        total += data.contact[i].frame[2] * force[0]
    return abs(total)


def test_the_file_loads_in_plain_mujoco(human, tmp_path):
    path = tmp_path / "model.xml"
    path.write_text(human.xml)
    model = mujoco.MjModel.from_xml_path(str(path))
    np.testing.assert_array_equal(model.body_mass, human.model.body_mass)
    assert [model.joint(i).name for i in range(model.njnt)] == list(human.joint_names)
    assert [model.body(i + 1).name for i in range(model.nbody - 1)] == list(human.body_names)
    for name, side, segment in human.contact_points:
        geom = model.geom(name)
        assert geom.group[0] == 3 and side in "rl" and segment


def test_names_lead_to_indices(human):
    for i, name in enumerate(human.coordinates):
        assert human.hinge(name) == i
        assert human.model.joint(name).qposadr[0] == 7 + i
        assert human.limits[0, i] == coordinate_of(name).low
    for name in human.body_names:
        assert human.model.body(name).id == human.body(name)


def test_unknown_names_raise_with_the_known_ones():
    human = person("42", "rigid")
    with pytest.raises(CoordinateNotFound, match="'mtp_angle_r'.*ankle_angle_r"):
        human.hinge("mtp_angle_r")
    with pytest.raises(CoordinateNotFound, match="'toes_r'.*pelvis"):
        human.body("toes_r")
    with pytest.raises(CoordinateNotFound, match="'knee_twist_r'.*knee_angle"):
        coordinate_of("knee_twist_r")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"height": 0.1}, "height is 0.1 m; allowed is 0.5 to 2.5 m"),
        ({"height": 174.0}, "height is 174.0 m; allowed is 0.5 to 2.5 m"),
        ({"height": float("nan")}, "height is nan"),
        ({"mass": 0}, "mass is 0 kg; allowed is 5 to 300 kg"),
        ({"sex": "other"}, "sex is 'other'; allowed are female, male"),
        ({"joints": "44"}, "joints is '44'; allowed are 42, 43, 58, 66"),
        ({"feet": "hooves"}, "feet is 'hooves'; allowed are rigid, two-segment, multi-segment"),
        ({"lengths": {"tail": 0.3}}, "unknown segment length 'tail'; allowed are ankle_height"),
        ({"lengths": {"thigh": 42.0}}, "thigh is 42.0 m; allowed is 0.01 to 1 m"),
        ({"lengths": {"thigh": 0.9, "shank": 0.9}}, "check them and their unit"),
    ],
)
def test_invalid_parameters_raise_with_the_allowed_range(given, message):
    with pytest.raises(ParameterError) as caught:
        Human.create(**given)
    assert message in str(caught.value)


def test_given_lengths_that_do_not_add_up_to_the_height_raise():
    average = Human.create().dimensions
    own = {n: getattr(average, n) for n in Dimensions.names()} | {"thigh": 0.5}
    with pytest.raises(ParameterError, match="add up to"):
        Human.create(lengths=own)


@pytest.mark.parametrize("sex", SEXES)
def test_own_lengths_are_kept_and_so_is_the_stature(sex):
    own = {
        "thigh": 0.46,
        "shank": 0.40,
        "upper_arm": 0.31,
        "forearm": 0.26,
        "foot_length": 0.29,
        "foot_width": 0.11,
        "pelvis_width": 0.26,
        "shoulder_width": 0.40,
    }
    human = Human.create(1.80, 80.0, sex, "58", "multi-segment", own)
    assert human.dimensions.height == pytest.approx(1.80, abs=1e-12)
    data = standing(human)

    def distance(a, b):
        return np.linalg.norm(data.xpos[human.body(a)] - data.xpos[human.body(b)])

    for side in ("r", "l"):
        assert distance(f"femur_{side}", f"tibia_{side}") == pytest.approx(0.46, rel=1e-3)
        assert distance(f"tibia_{side}", f"foot_{side}") == pytest.approx(0.40, rel=1e-3)
        assert distance(f"humerus_{side}", f"ulna_{side}") == pytest.approx(0.31, rel=1e-3)
        assert distance(f"ulna_{side}", f"hand_{side}") == pytest.approx(0.26, rel=1e-9)
    assert distance("humerus_r", "humerus_l") == pytest.approx(0.40, rel=1e-9)


@given(
    height=st.floats(0.9, 2.2),
    mass=st.floats(10.0, 200.0),
    sex=st.sampled_from(SEXES),
    preset=st.sampled_from(PRESETS),
)
@settings(max_examples=25, deadline=None)
def test_every_person_can_be_built(height, mass, sex, preset):
    human = Human.create(height, mass, sex, *preset)
    assert human.model.body_mass.sum() == pytest.approx(mass, rel=1e-12)
    assert human.dimensions.height == pytest.approx(height, abs=1e-12)
    data = standing(human)
    assert 0.54 < data.subtree_com[1, 2] / height < 0.58


def test_geometry_scales_with_stature():
    small, large = Human.create(0.87, 71.0), Human.create(1.74, 71.0)
    # Harrington's hip regression has constant terms [m], so scaling is approximate.
    np.testing.assert_allclose(2 * standing(small).xpos[1:], standing(large).xpos[1:], atol=0.03)


def test_mass_scales_every_segment_alike():
    light, heavy = Human.create(mass=50.0).model, Human.create(mass=100.0).model
    np.testing.assert_allclose(2 * light.body_mass, heavy.body_mass, rtol=1e-12)
    np.testing.assert_allclose(2 * light.body_inertia, heavy.body_inertia, rtol=1e-9)


@pytest.mark.parametrize("feet", FEET)
def test_the_joint_set_does_not_change_the_body(feet):
    """One anatomy: at rest all joint sets have the same mass, centre of mass and inertia."""
    found = []
    for joints in JOINT_SETS:
        human = person(joints, feet)
        data = mujoco.MjData(human.model)  # the zero pose, in which the parts are described
        mujoco.mj_forward(human.model, data)
        M = np.zeros((human.model.nv, human.model.nv))
        mujoco.mj_fullM(human.model, data, M)
        found.append(M[:6, :6])
    for M in found[1:]:
        np.testing.assert_allclose(M, found[0], atol=1e-10)


def test_the_foot_papers_subject():
    human = Human.create(height=1.50, mass=48.5, joints="66")
    assert human.feet == "multi-segment"
    assert human.model.nv == 66
    assert human.model.body_mass.sum() == pytest.approx(48.5, rel=1e-12)
    assert human.dimensions.height == pytest.approx(1.50, abs=1e-12)


def test_opensim_coordinates_round_trip(human):
    rng = np.random.default_rng(0)
    q = np.stack([random_state(human, rng)[0] for _ in range(20)])
    names, values = human.to_coordinates(q)
    assert names[:6] == PELVIS
    back = human.from_coordinates(names, values)
    np.testing.assert_allclose(back[:, :3], q[:, :3], atol=1e-12)
    np.testing.assert_allclose(back[:, 7:], q[:, 7:], atol=1e-15)
    same = np.abs(np.einsum("ij,ij->i", back[:, 3:7], q[:, 3:7]))
    np.testing.assert_allclose(same, 1.0, atol=1e-12)


def test_a_turning_walk_keeps_its_heading():
    human = person("42", "rigid")
    heading = np.linspace(-5.0, 25.0, 500)  # several turns
    names = ("pelvis_tilt", "pelvis_rotation", "pelvis_tx", "pelvis_ty", "pelvis_tz")
    values = np.stack(
        [0.1 * np.ones(500), heading, np.cos(heading), 0.9 + 0 * heading, np.sin(heading)], axis=1
    )
    got_names, got = human.to_coordinates(human.from_coordinates(names, values))
    columns = [got_names.index(n) for n in names]
    turns = np.round((got[0, columns[1]] - heading[0]) / (2 * np.pi)) * 2 * np.pi
    got[:, columns[1]] -= turns  # the first frame may be counted from another whole turn
    np.testing.assert_allclose(got[:, columns], values, atol=1e-9)


def test_unknown_coordinates_are_ignored_and_missing_ones_keep_standing_values():
    human = person("42", "rigid")
    names, values = ("knee_angle_r", "knee_angle_r_beta"), np.array([[0.5, 9.0]])
    q = human.from_coordinates(names, values)
    expected = human.standing()
    expected[7 + human.hinge("knee_angle_r")] = 0.5
    np.testing.assert_allclose(q[0], expected, atol=1e-12)
    with pytest.raises(ParameterError, match="none of the columns a, b"):
        human.from_coordinates(("a", "b"), np.zeros((1, 2)))


def test_opensim_translation_is_converted_to_world_axes():
    human = person("42", "rigid")
    q = human.from_coordinates(PELVIS[3:], np.array([[1.0, 0.9, 0.3]]))  # forward, up, right
    np.testing.assert_allclose(q[0, :3], [1.0, -0.3, 0.9])


def test_other_lengths_move_the_bodies_and_nothing_else(human):
    longer = Human.create(
        1.74, 71.0, "male", human.joints, human.feet, {"thigh": 0.45, "forearm": 0.3}
    )
    np.testing.assert_allclose(
        human.body_positions(longer.dimensions)[1:], longer.model.body_pos[2:], atol=1e-15
    )
