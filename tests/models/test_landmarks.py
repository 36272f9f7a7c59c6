"""Landmarks: plausible positions on every body of the package."""

import mujoco
import numpy as np
import pytest

from plantigrade.models import Human
from plantigrade.models.landmarks import attachments, landmarks
from tests.models.presets import PRESETS, other_side, person


@pytest.fixture(params=PRESETS, ids="-".join)
def human(request):
    return person(*request.param)


def places(human, qpos=None):
    """World position of every landmark."""
    data = mujoco.MjData(human.model)
    data.qpos = human.model.qpos0 if qpos is None else qpos
    mujoco.mj_kinematics(human.model, data)
    found = {}
    for name, place in attachments(human).items():
        body = human.body(place.body)
        found[name] = data.xpos[body] + data.xmat[body].reshape(3, 3) @ place.position
    return found


def test_every_landmark_is_carried_by_a_body(human):
    found = attachments(human)
    assert set(found) == set(landmarks(human.dimensions))
    for place in found.values():
        assert place.body in human.body_names
        assert 0.005 <= place.spread < 0.1
        assert np.isfinite(place.position).all()


def test_left_and_right_mirror(human):
    found = places(human)
    for name, x in found.items():
        np.testing.assert_allclose(found[other_side(name)], x * [1, -1, 1], atol=1e-12)
    for name, x in found.items():
        if name.endswith("_r"):
            assert x[1] < 0, name
        elif not name.endswith("_l"):
            assert x[1] == pytest.approx(0, abs=1e-12), name


def test_the_joint_set_does_not_move_a_landmark(human):
    """In the zero pose all joint sets and feet put a landmark in the same place."""
    reference, found = places(person("42", "rigid")), places(human)
    for name, x in found.items():
        np.testing.assert_allclose(x, reference[name], atol=1e-12, err_msg=name)


@pytest.mark.parametrize(
    "chain",
    [
        "vertex head_front_r temple_r ear_r c7 t2 t4 t6 t8 t10 t12 l3 l5 sacrum".split(),
        "vertex suprasternale sternum xiphoid asis_r pubis".split(),
        "acromion_r shoulder_joint_r upper_arm_r elbow_lateral_r forearm_r wrist_ulnar_r hand_r "
        "finger_tip_r".split(),
        "iliac_crest_r asis_r hip_joint_r thigh_upper_r thigh_front_r thigh_r knee_lateral_r "
        "knee_joint_r fibula_head_r tibial_tuberosity_r shank_upper_r shank_front_r "
        "ankle_lateral_r metatarsal_5_head_r".split(),
        "iliac_crest_r psis_r hip_joint_r".split(),
        "ankle_medial_r ankle_lateral_r ankle_joint_r".split(),
    ],
    ids=lambda chain: chain[0] + "-" + chain[-1],
)
def test_order_from_head_to_foot(chain):
    found = places(person("42", "two-segment"))
    heights = [found[name][2] for name in chain]
    assert heights == sorted(heights, reverse=True)


@pytest.mark.parametrize(
    ("front", "back"),
    [
        ("asis_r", "psis_r"),
        ("suprasternale", "c7"),
        ("xiphoid", "t10"),
        ("forehead", "occiput"),
        ("head_front_r", "head_back_r"),
        ("patella_r", "knee_lateral_r"),
        ("toe_tip_r", "hallux_r"),
        ("hallux_r", "metatarsal_1_head_r"),
        ("metatarsal_2_head_r", "metatarsal_5_head_r"),
        ("metatarsal_5_head_r", "metatarsal_5_base_r"),
        ("metatarsal_5_base_r", "heel_r"),
        ("navicular_r", "sustentaculum_r"),
        ("sustentaculum_r", "heel_r"),
        ("heel_r", "heel_wand_r"),
        ("shank_front_r", "shank_rear_r"),
    ],
)
def test_order_from_front_to_back(front, back):
    found = places(person("66", "multi-segment"))
    assert found[front][0] > found[back][0]


@pytest.mark.parametrize(
    ("outer", "inner"),
    [
        ("knee_lateral_r", "knee_medial_r"),
        ("ankle_lateral_r", "ankle_medial_r"),
        ("elbow_lateral_r", "elbow_medial_r"),
        ("wrist_radial_r", "wrist_ulnar_r"),  # palms forward: the thumb points outward
        ("hand_radial_r", "hand_ulnar_r"),
        ("metatarsal_5_head_r", "metatarsal_1_head_r"),
        ("heel_lateral_r", "heel_medial_r"),
        ("trochanter_r", "hip_joint_r"),
        ("asis_r", "psis_r"),
    ],
)
def test_order_from_outside_to_inside(outer, inner):
    found = places(person("42", "rigid"))
    assert found[outer][1] < found[inner][1]


def test_joint_centres_are_the_joints():
    human = person("43", "rigid")
    found, data = places(human), mujoco.MjData(human.model)
    mujoco.mj_kinematics(human.model, data)
    for mark, body in (
        ("hip_joint_r", "femur_r"),
        ("knee_joint_r", "tibia_r"),
        ("ankle_joint_r", "foot_r"),
        ("shoulder_joint_r", "humerus_r"),
        ("elbow_joint_r", "ulna_r"),
        ("wrist_joint_r", "hand_r"),
    ):
        assert np.linalg.norm(found[mark] - data.xpos[human.body(body)]) < 0.004, mark


def test_pairs_lie_on_both_sides_of_their_joint():
    found = places(person("42", "rigid"))
    for joint in ("knee", "ankle", "elbow"):
        lateral, medial = found[f"{joint}_lateral_r"], found[f"{joint}_medial_r"]
        assert np.linalg.norm((lateral + medial) / 2 - found[f"{joint}_joint_r"]) < 0.025
        assert 0.05 < np.linalg.norm(lateral - medial) < 0.14


def test_landmarks_lie_on_the_body():
    """Landmarks are within a hand's width of the drawn shapes and above the floor."""
    human = person("42", "two-segment")
    data = mujoco.MjData(human.model)
    data.qpos = human.standing()
    mujoco.mj_forward(human.model, data)
    point_geom = [g for g in range(human.model.ngeom) if human.model.geom_group[g] == 1]
    for name, x in places(human, human.standing()).items():
        assert 0 < x[2] < 1.02 * human.height, name
        d = min(_distance(human.model, data, g, x) for g in point_geom)
        assert d < 0.08, name


def _distance(model, data, geom, x):
    """Distance from a point to a capsule, box or ellipsoid (its bounding box), 0 inside."""
    local = data.geom_xmat[geom].reshape(3, 3).T @ (x - data.geom_xpos[geom])
    size = model.geom_size[geom]
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
        local[2] -= np.clip(local[2], -size[1], size[1])
        return max(np.linalg.norm(local) - size[0], 0.0)
    return np.linalg.norm(np.maximum(np.abs(local) - size, 0.0))


def test_landmarks_follow_the_lengths():
    human = person("42", "two-segment")
    longer = Human.create(lengths={"thigh": 0.48})
    moved = attachments(human, longer.dimensions)
    direct = attachments(longer)
    for name, place in direct.items():
        np.testing.assert_allclose(moved[name].position, place.position, atol=1e-15)


def test_toe_markers_move_with_the_toes_where_there_are_toes():
    assert attachments(person("42", "rigid"))["hallux_r"].body == "foot_r"
    assert attachments(person("42", "two-segment"))["hallux_r"].body == "toes_r"
    multi = attachments(person("66", "multi-segment"))
    assert multi["hallux_r"].body == "medial_phalanges_r"
    assert multi["toe_5_r"].body == "lateral_phalanges_r"
    assert multi["heel_r"].body == "heel_r"
    assert multi["metatarsal_5_head_r"].body == "lateral_metatarsal_r"
    assert multi["metatarsal_1_head_r"].body == "foot_r"
