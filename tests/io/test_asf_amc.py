import re

import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.io.amc import read_amc
from plantigrade.io.asf import find_asf, read_asf
from plantigrade.io.bvh import read_bvh

WALKS = {  # mean speeds by the data's own description [m/s]
    "02_01": 1.16,
    "02_02": 1.60,
    "07_01": 1.33,
    "07_08": 1.33,
    "07_12": 1.92,
    "16_15": 1.07,
    "16_21": 1.67,
    "49_01": 0.83,
}

LEG = """:version 1.10
:name test
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lfemur
     direction 0 -1 0
     length 10
     axis 0 0 0 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name ltibia
     direction 0 -1 0
     length 10
     axis 0 0 20 XYZ
    dof rx
    limits (-10.0 170.0)
  end
  begin
     id 3
     name head
     direction 0 1 0
     length 8
     axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root lfemur head
    lfemur ltibia
  end
"""
AMC = """#comment
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 0 0
lfemur 0 0 0
ltibia 0
2
root 1 2 4 0 90 0
lfemur -90 0 0
ltibia 90
3
root 1 2 5 0 0 0
lfemur 0 0 90
ltibia 0
"""
UNIT = 0.0254 / 0.45


@pytest.fixture
def leg(tmp_path):
    (tmp_path / "leg.asf").write_text(LEG)
    (tmp_path / "leg_01.amc").write_text(AMC)
    return tmp_path / "leg_01.amc"


def knee(skeleton, side):
    """Angle between thigh and shank [rad]."""
    i, j = skeleton.names.index(f"{side}femur"), skeleton.names.index(f"{side}tibia")
    thigh = skeleton.ends[:, i] - skeleton.positions[:, i]
    shank = skeleton.ends[:, j] - skeleton.positions[:, j]
    return angle_between(thigh, shank)


def angle_between(a, b):
    cosine = np.sum(a * b, -1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return np.arccos(np.clip(cosine, -1, 1))


def test_a_leg_by_hand(leg):
    recording = read_amc(leg)
    s = recording.skeleton
    assert s.names == ("root", "lfemur", "ltibia", "head")
    np.testing.assert_allclose(s.time, [0, 1 / 120, 2 / 120])
    # file (x left, y up, z forward) -> ours (x forward, y left, z up)
    np.testing.assert_allclose(s.positions[:, 0] / UNIT, [[3, 1, 2], [4, 1, 2], [5, 1, 2]])
    np.testing.assert_allclose(s.ends[0, 2] / UNIT, [3, 1, 2 - 20], atol=1e-9)
    # Turned by 90 degrees about the vertical the person faces left (z to x in the file); hip
    # flexed by 90 degrees: the thigh points there; knee flexed by 90: the shank hangs down.
    np.testing.assert_allclose(s.ends[1, 1] / UNIT, [4, 11, 2], atol=1e-9)
    # The knee's axis stands at 20 degrees about the bone frame's z: rx bends in that plane.
    c, sn = np.cos(np.deg2rad(20)), np.sin(np.deg2rad(20))
    shank = (s.ends[1, 2] - s.positions[1, 2]) / UNIT / 10
    assert shank[2] == pytest.approx(-c, abs=1e-9)
    assert np.linalg.norm(shank) == pytest.approx(1)
    assert sn > 0
    # rz = 90 in the file swings the left leg (-y) to +x: to the left, abduction.
    np.testing.assert_allclose(s.ends[2, 1] / UNIT, [5, 11, 2], atol=1e-9)
    for rotation in s.rotations.reshape(-1, 3, 3):
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1)
    assert any("120 Hz" in text for text in recording.warnings)


def test_order_of_rotations(leg):
    # RX 90 then RZ 90 about fixed axes: z -> -y -> x; so file z ends on x.
    leg.write_text(AMC.replace("root 1 2 3 0 0 0", "root 0 0 0 90 0 90"))
    R = read_amc(leg).skeleton.rotations[0, 0]  # ours: file z = x, file x = y, file y = z
    np.testing.assert_allclose(R @ [1, 0, 0], [0, 1, 0], atol=1e-12)


def test_options(leg):
    assert read_amc(leg, rate=60).skeleton.time[1] == pytest.approx(1 / 60)
    metres = read_amc(leg, unit="cm").skeleton
    assert np.linalg.norm(metres.ends[0, 1] - metres.positions[0, 1]) == pytest.approx(0.1 / 0.45)
    radians = leg.with_name("leg_02.amc")
    text = AMC.replace(":DEGREES", ":RADIANS").replace("90", f"{np.pi / 2:.17g}")
    radians.write_text(text)
    np.testing.assert_allclose(
        read_amc(radians).skeleton.ends, read_amc(leg).skeleton.ends, atol=1e-9
    )
    with pytest.raises(ParameterError, match="rate"):
        read_amc(leg, rate=-1)
    with pytest.raises(ParameterError, match="unit"):
        read_amc(leg, unit="ell")


def test_another_unit_is_found(leg):
    leg.with_name("leg.asf").write_text(LEG.replace("length 0.45", "length 0.2"))
    recording = read_amc(leg)  # in inches 3.5 m tall: cm fits
    assert any("cm" in text for text in recording.warnings)


@pytest.mark.parametrize("trial", WALKS)
def test_walks_are_physical(data, trial):
    s = read_amc(data / "cmu_asfamc" / f"{trial}.amc").skeleton
    length = np.linalg.norm(s.ends - s.positions, axis=-1)
    assert np.ptp(length, axis=0).max() < 1e-9
    pelvis = s.positions[:, 0]
    assert 0.85 < np.median(pelvis[:, 2]) < 1.05
    speed = np.linalg.norm(np.gradient(pelvis[:, :2], s.time, axis=0), axis=1)
    assert np.median(speed) == pytest.approx(WALKS[trial], abs=0.03)
    toes = [s.names.index(name) for name in ("ltoes", "rtoes")]
    lowest = s.ends[:, toes, 2].min(axis=1)
    assert abs(np.median(lowest)) < 0.06
    # The person walks the way the pelvis faces, and the left hip is on the left.
    walking = pelvis[-1, :2] - pelvis[0, :2]
    facing = s.rotations[:, 0, :2, 0].mean(axis=0)
    assert walking @ facing > 0.9 * np.linalg.norm(walking) * np.linalg.norm(facing)
    assert s.rest_positions[s.names.index("lfemur"), 1] > 0.05
    for side in "lr":
        bend = knee(s, side)
        assert 0.6 < np.ptp(bend) < 1.4
        # Knees flex backwards: the shank's end lies behind the line of the thigh.
        i, j = s.names.index(f"{side}femur"), s.names.index(f"{side}tibia")
        n = int(np.argmax(bend))
        thigh = s.ends[n, i] - s.positions[n, i]
        shank = s.ends[n, j] - s.positions[n, j]
        forward = np.array([*walking, 0.0]) / np.linalg.norm(walking)
        off = shank - thigh * (shank @ thigh) / (thigh @ thigh)
        assert off @ forward < 0


def test_twins_agree(data):
    amc = read_amc(data / "cmu_asfamc" / "07_01.amc").skeleton
    bvh = read_bvh(data / "cmu_bvh" / "07_01.bvh").skeleton
    speed = [
        np.linalg.norm(s.positions[-1, 0, :2] - s.positions[0, 0, :2]) / (s.time[-1] - s.time[0])
        for s in (amc, bvh)
    ]
    assert speed[0] == pytest.approx(speed[1], rel=0.03)
    # The conversion keeps the joint angles, sample for sample from the frame after the rest pose.
    hip, shin, foot = (bvh.positions[:, bvh.names.index(n)] for n in ("rThigh", "rShin", "rFoot"))
    bend = angle_between(shin - hip, foot - shin)
    same = np.interp(bvh.time, amc.time, knee(amc, "r"))
    assert np.ptp(bend) == pytest.approx(np.ptp(same), rel=0.1)
    assert np.corrcoef(bend, same)[0, 1] > 0.98


def test_incomplete_frame_is_dropped(data):
    recording = read_amc(data / "cmu_asfamc" / "07_12.amc")
    assert len(recording.skeleton.time) == 244
    assert any("ltoes" in text for text in recording.warnings)


def test_bones_that_are_zero_until_they_are_known_are_kept_as_then(leg):
    moved = AMC.replace("lfemur -90 0 0", "lfemur -80 5 0").replace(
        "lfemur 0 0 90", "lfemur -70 6 0"
    )
    begins = moved.replace("root 1 2 3 0 0 0", "root 1 2 3 0 9 0").replace(
        "ltibia 0\n2", "ltibia 7\n2"
    )
    leg.write_text(begins)
    unknown = read_amc(leg)
    leg.write_text(begins.replace("lfemur 0 0 0", "lfemur -80 5 0"))
    known = read_amc(leg)
    np.testing.assert_allclose(unknown.skeleton.ends, known.skeleton.ends)
    assert any("nearest frame: lfemur" in text for text in unknown.warnings)
    assert not any("nearest frame" in text for text in known.warnings)
    leg.write_text(moved)  # a rest pose that was meant: the knee is straight, too
    assert not any("nearest frame" in text for text in read_amc(leg).warnings)


def test_missing_frame_keeps_its_time(leg):
    leg.write_text(AMC.replace("2\nroot 1 2 4 0 90 0\nlfemur -90 0 0\nltibia 90\n", ""))
    np.testing.assert_allclose(read_amc(leg).skeleton.time, [0, 2 / 120])


def test_cut_off_end_is_dropped(leg):
    for end in ("lfemur 0 0", "lfem", "lfemur 0 0 -"):
        leg.write_text(AMC[: AMC.rindex("lfemur")] + end)
        recording = read_amc(leg)
        assert len(recording.skeleton.time) == 2
        assert any("left out" in text for text in recording.warnings)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("ltibia 90", "ltibia 90 1", r"line 11: 'ltibia' has 2 values"),
        ("ltibia 90", "ltibia x", r"line 11: the values of 'ltibia'"),
        ("ltibia 90", "lshin 90", r"line 11: 'lshin' is not a bone .* skeleton=FILE"),
        ("\n3\n", "\n1\n", r"line 12: frame 1 comes after frame 2"),
        ("root 1 2", "rot 1 2", r"'rot' is not a bone"),
    ],
)
def test_bad_motion(leg, old, new, match):
    leg.write_text(AMC.replace(old, new))
    with pytest.raises(FileError, match=match):
        read_amc(leg)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        (":hierarchy", ":hier", "no :hierarchy"),
        ("length 10", "length ten", r"line \d+: 'ten' is not a number"),
        ("lfemur ltibia", "lfemur shin", "'shin', which is not in :bonedata"),
        ("    lfemur ltibia\n", "", "not connected to the root: ltibia"),
        ("axis 0 0 20 XYZ", "axis 0 0 20 XXZ", "'XXZ'; it must contain"),
        ("dof rx\n", "dof qx\n", "dof is qx; allowed"),
        (
            "limits (-160.0 20.0)",
            "limits (-160.0 wide)",
            r"limits \(-160.0 wide\) are not two numbers",
        ),
        ("direction 0 1 0", "direction 0 0 0", "no direction"),
        ("length 0.45", "length 0", "must be positive"),
        ("  end\n:hier", ":hier", "has no end"),
        ("id 3\n     name head", "id 3\n     name ltibia", "two bones named"),
    ],
)
def test_bad_skeleton(leg, old, new, match):
    leg.with_name("leg.asf").write_text(LEG.replace(old, new))
    with pytest.raises(FileError, match=match):
        read_amc(leg)


def test_companion(leg, data):
    assert find_asf(leg) == leg.with_name("leg.asf")
    assert find_asf(data / "cmu_asfamc" / "131_12.amc").name == "131.asf"
    other = leg.with_name("other.amc")
    other.write_text(AMC)
    assert find_asf(other) == leg.with_name("leg.asf")  # the only one
    leg.with_name("LEG2.ASF").write_text(LEG)
    assert find_asf(leg.with_name("leg2_05.amc")).name == "LEG2.ASF"
    with pytest.raises(FileError, match=r"several skeletons.*skeleton=FILE.asf"):
        find_asf(other)
    assert len(read_amc(other, skeleton=leg.with_name("LEG2.ASF")).skeleton.time) == 3
    leg.with_name("leg.asf").unlink()
    leg.with_name("LEG2.ASF").unlink()
    with pytest.raises(FileError, match="no skeleton file"):
        read_amc(other)
    with pytest.raises(FileError, match="no such file"):
        read_amc(other, skeleton=leg.with_name("gone.asf"))


def test_every_skeleton(data):
    for path in sorted((data / "cmu_asfamc").glob("*.asf")):
        skeleton = read_asf(path)
        assert len(skeleton.bones) == 30
        assert sum(len(bone.dof) for bone in skeleton.bones) == 56


def test_irregular_reading_agrees_with_regular(data, tmp_path):
    source = data / "cmu_asfamc" / "07_01.amc"
    text = source.read_text()
    cut = re.sub(r"^2\n", "# a comment takes the slow way\n2\n", text, count=1, flags=re.MULTILINE)
    slow = tmp_path / "07_01.amc"
    slow.write_text(cut)
    a = read_amc(source).skeleton
    b = read_amc(slow, skeleton=source.with_name("07.asf")).skeleton
    np.testing.assert_array_equal(a.ends, b.ends)
