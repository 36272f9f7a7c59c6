"""A positive coordinate means what its name says, on both sides of the body."""

import mujoco
import numpy as np
import pytest

from plantigrade.models.coordinates import COORDINATES
from plantigrade.models.landmarks import attachments
from tests.models.presets import person

FORWARD, LEFT, UP = np.eye(3)
OUT, IN = "out", "in"  # away from and towards the midline
BACK, DOWN = -FORWARD, -UP

# coordinate, joint set, foot, landmark (without side on a limb), direction of its motion
MEANINGS = [
    ("hip_flexion", "42", "rigid", "knee_lateral", FORWARD),
    ("hip_adduction", "42", "rigid", "ankle_lateral", IN),
    ("hip_rotation", "42", "rigid", "hallux", IN),
    ("knee_angle", "42", "rigid", "heel", BACK),
    ("knee_angle", "42", "rigid", "heel", UP),
    ("knee_adduction", "66", "rigid", "ankle_lateral", IN),
    ("knee_rotation", "66", "rigid", "hallux", IN),
    ("ankle_angle", "42", "rigid", "hallux", UP),
    ("subtalar_angle", "42", "rigid", "metatarsal_1_head", UP),
    ("subtalar_angle", "42", "rigid", "hallux", IN),
    ("ankle_rotation", "58", "rigid", "hallux", IN),
    ("mtp_angle", "42", "two-segment", "toe_tip", UP),
    ("mtp_angle", "66", "multi-segment", "toe_tip", UP),
    ("mtp_inversion", "66", "multi-segment", "hallux", UP),
    ("mtp_adduction", "66", "multi-segment", "hallux", IN),
    ("mtp4_angle", "66", "multi-segment", "toe_5", UP),
    ("mtp4_adduction", "66", "multi-segment", "toe_5", IN),
    ("mtp4_inversion", "66", "multi-segment", "toe_5", DOWN),
    ("cuboid_angle", "66", "multi-segment", "metatarsal_5_head", UP),
    ("cuboid_inversion", "66", "multi-segment", "metatarsal_5_head", DOWN),
    ("cuboid_adduction", "66", "multi-segment", "metatarsal_5_head", IN),
    ("heel_angle", "66", "multi-segment", "heel", DOWN),
    ("heel_inversion", "66", "multi-segment", "sustentaculum", UP),
    ("heel_adduction", "66", "multi-segment", "heel", OUT),
    ("lumbar_extension", "42", "rigid", "c7", BACK),
    ("lumbar_bending", "42", "rigid", "c7", -LEFT),
    ("lumbar_rotation", "42", "rigid", "sternum", LEFT),
    ("lower_thorax_extension", "58", "rigid", "c7", BACK),
    ("lower_thorax_bending", "58", "rigid", "c7", -LEFT),
    ("lower_thorax_rotation", "58", "rigid", "sternum", LEFT),
    ("thorax_extension", "58", "rigid", "c7", BACK),
    ("thorax_bending", "58", "rigid", "c7", -LEFT),
    ("thorax_rotation", "58", "rigid", "suprasternale", LEFT),
    ("lower_neck_extension", "58", "rigid", "vertex", BACK),
    ("lower_neck_bending", "58", "rigid", "vertex", -LEFT),
    ("lower_neck_rotation", "58", "rigid", "forehead", LEFT),
    ("upper_neck_extension", "58", "rigid", "vertex", BACK),
    ("upper_neck_bending", "58", "rigid", "vertex", -LEFT),
    ("upper_neck_rotation", "58", "rigid", "forehead", LEFT),
    ("neck_extension", "42", "rigid", "vertex", BACK),
    ("neck_bending", "42", "rigid", "vertex", -LEFT),
    ("neck_rotation", "42", "rigid", "forehead", LEFT),
    ("clavicle_elevation", "58", "rigid", "acromion", UP),
    ("clavicle_protraction", "58", "rigid", "acromion", FORWARD),
    ("arm_flex", "42", "rigid", "elbow_lateral", FORWARD),
    ("arm_add", "42", "rigid", "elbow_lateral", IN),
    ("elbow_flex", "42", "rigid", "wrist_radial", FORWARD),
    ("elbow_adduction", "66", "rigid", "wrist_joint", IN),
    ("pro_sup", "42", "rigid", "hand_radial", FORWARD),
    ("wrist_flex", "42", "rigid", "finger_tip", FORWARD),
    ("wrist_dev", "42", "rigid", "finger_tip", IN),
    ("fingers_flex", "42", "rigid", "finger_tip", FORWARD),
]


def path_of(human, landmark, coordinate, angle):
    """Displacement of a landmark, in the pelvis frame, for one coordinate off the zero pose."""
    place = attachments(human)[landmark]
    data = mujoco.MjData(human.model)
    points = []
    for value in (0.0, angle):
        data.qpos = human.model.qpos0
        data.qpos[7 + human.hinge(coordinate)] = value
        mujoco.mj_kinematics(human.model, data)
        body = human.body(place.body)
        points.append(data.xpos[body] + data.xmat[body].reshape(3, 3) @ place.position)
    return points[1] - points[0]


@pytest.mark.parametrize(
    ("coordinate", "joints", "feet", "landmark", "way"),
    MEANINGS,
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_positive_means_what_the_name_says(coordinate, joints, feet, landmark, way):
    human = person(joints, feet)
    midline = coordinate in human.coordinates
    angle = 0.3
    for side in ("",) if midline else ("_r", "_l"):
        outward = LEFT if side == "_l" else -LEFT
        direction = {OUT: outward, IN: -outward}.get(way, way) if isinstance(way, str) else way
        moved = path_of(human, landmark + side, coordinate + side, angle)
        assert moved @ direction > 0.001


def test_inward_rotation_of_the_arm():
    """With the elbow bent, positive arm_rot brings the hand in front of the belly."""
    human = person("42", "rigid")
    for side, inward in (("r", LEFT), ("l", -LEFT)):
        place = attachments(human)[f"wrist_joint_{side}"]
        data = mujoco.MjData(human.model)
        y = []
        for turn in (0.0, 0.5):
            data.qpos = human.model.qpos0
            data.qpos[7 + human.hinge(f"elbow_flex_{side}")] = np.pi / 2
            data.qpos[7 + human.hinge(f"arm_rot_{side}")] = turn
            mujoco.mj_kinematics(human.model, data)
            body = human.body(place.body)
            y.append(data.xpos[body] + data.xmat[body].reshape(3, 3) @ place.position)
        assert (y[1] - y[0]) @ inward > 0.05


def test_full_pronation_turns_the_palm_back():
    """From palms forward to palms back, by way of the thumb in front."""
    human = person("42", "rigid")
    for side, inward in (("r", LEFT), ("l", -LEFT)):
        moved = path_of(human, f"hand_radial_{side}", f"pro_sup_{side}", np.pi)
        assert moved @ inward > 0.02
        palm = path_of(human, f"hand_{side}", f"pro_sup_{side}", np.pi)  # on the back of the hand
        assert palm @ FORWARD > 0.02


def test_every_coordinate_is_covered():
    seen_elsewhere = {"arm_rot"}  # along the arm; seen with the elbow bent, above
    assert {row[0] for row in MEANINGS} | seen_elsewhere == set(COORDINATES)


@pytest.mark.parametrize("name", COORDINATES)
def test_every_row_is_complete(name):
    row = COORDINATES[name]
    assert row.low < 0 < row.high
    assert row.weakest < 0 < row.strongest
    assert np.linalg.norm(row.axis_of("r")) == pytest.approx(1.0)
    np.testing.assert_allclose(row.axis_of("l"), row.axis_of("r") * [-1, 1, -1])
    assert row.strength_source and row.range_source
