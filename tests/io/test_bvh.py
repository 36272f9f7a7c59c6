import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.io.amc import read_amc
from plantigrade.io.bvh import read_bvh
from plantigrade.io.bvh_writer import write_bvh
from plantigrade.io.deepmimic import read_deepmimic

BODY = """HIERARCHY
ROOT hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT leftThigh
  {
    OFFSET 10 0 0
    CHANNELS 3 Xrotation Yrotation Zrotation
    JOINT leftFoot
    {
      OFFSET 0 -90 0
      CHANNELS 3 Yrotation Zrotation Xrotation
      End Site
      {
        OFFSET 0 0 15
      }
    }
  }
  JOINT rightThigh
  {
    OFFSET -10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT rightFoot
    {
      OFFSET 0 -90 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 0 15
      }
    }
  }
  JOINT head
  {
    OFFSET 0 70 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 10 0
    }
  }
}
"""
ZEROS = " ".join(["0"] * 12)
MOTION = f"""MOTION
Frames: 3
Frame Time: 0.01
5 90 7 0 0 0 -90 0 0 {ZEROS}
5 90 8 0 0 90 0 90 0 {ZEROS}
5 90 9 90 0 90 10 20 30 {ZEROS}
"""


@pytest.fixture
def body(tmp_path):
    path = tmp_path / "body.bvh"
    path.write_text(BODY + MOTION)
    return path


def test_a_body_by_hand(body):
    recording = read_bvh(body)
    s = recording.skeleton
    assert s.names == ("hips", "leftThigh", "leftFoot", "rightThigh", "rightFoot", "head")
    np.testing.assert_allclose(s.time, [0, 0.01, 0.02])
    # File (x left, y up, z forward, cm) to ours (x forward, y left, z up, m).
    np.testing.assert_allclose(s.positions[0, 0], [0.07, 0.05, 0.90])
    np.testing.assert_allclose(s.rest_positions[1], [0, 0.1, 0], atol=1e-12)
    # Frame 1: the left hip flexed by 90 degrees puts the foot before the hip.
    np.testing.assert_allclose(s.positions[0, 2], [0.97, 0.15, 0.90], atol=1e-9)
    np.testing.assert_allclose(s.ends[0, 2], [0.97, 0.15, 1.05], atol=1e-9)
    # Frame 2: turned left by 90 degrees; forward is now y, left is -x; hip turned by 90 more.
    np.testing.assert_allclose(s.positions[1, 1], [0.08 - 0.1, 0.05, 0.9], atol=1e-9)
    np.testing.assert_allclose(s.ends[1, 2], [0.08 - 0.1 - 0.15, 0.05, 0.0], atol=1e-9)
    # Frame 3: R = Rz(90) Ry(90): file x goes to -z, so the left hip lies behind (ours -x).
    np.testing.assert_allclose(s.positions[2, 1], [0.09 - 0.1, 0.05, 0.9], atol=1e-9)
    assert np.isnan(s.ends[:, 0]).all() and np.isfinite(s.ends[:, 5]).all()


@pytest.mark.parametrize(("factor", "unit"), [(0.01, "m"), (1, "cm"), (10, "mm"), (1 / 2.54, "in")])
def test_unit_is_found(body, tmp_path, factor, unit):
    skeleton = read_bvh(body).skeleton
    lines = []
    for line in (BODY + MOTION).splitlines():
        words = line.split()
        if "OFFSET" in line:
            line = "OFFSET " + " ".join(str(float(w) * factor) for w in words[1:])
        elif len(words) == 21:
            line = " ".join([str(float(w) * factor) for w in words[:3]] + words[3:])
        lines.append(line)
    path = tmp_path / "scaled.bvh"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(read_bvh(path).skeleton.positions, skeleton.positions, atol=1e-9)
    np.testing.assert_allclose(
        read_bvh(path, unit=unit).skeleton.positions, skeleton.positions, atol=1e-9
    )
    with pytest.raises(ParameterError, match="unit"):
        read_bvh(path, unit="ell")


def test_z_up_and_facing_elsewhere(body, tmp_path):
    """The same body written z up, facing -y, comes out the same."""
    lines = []

    def turned(x, y, z):  # x left, y up, z forward -> x left, z up, -y forward
        return f"{x} {-float(z)} {y}"

    axes = {
        "Xrotation": ("Xrotation", 1),
        "Yrotation": ("Zrotation", 1),
        "Zrotation": ("Yrotation", -1),
    }
    signs = []
    for line in BODY.splitlines():
        words = line.split()
        if "OFFSET" in line:
            line = "OFFSET " + turned(*words[1:])
        elif "CHANNELS" in line:
            channels = [w for w in words[2:] if w.endswith("rotation")]
            signs += [axes[w][1] for w in channels]
            line = " ".join(
                words[:2]
                + [w for w in words[2:] if w.endswith("position")]
                + [axes[w][0] for w in channels]
            )
        lines.append(line)
    for line in MOTION.splitlines():
        words = line.split()
        if len(words) == 21:
            angles = [str(float(w) * s) for w, s in zip(words[3:], signs, strict=True)]
            line = " ".join([turned(*words[:3]), *angles])
        lines.append(line)
    path = tmp_path / "z_up.bvh"
    path.write_text("\n".join(lines))
    a, b = read_bvh(body).skeleton, read_bvh(path).skeleton
    np.testing.assert_allclose(a.positions, b.positions, atol=1e-9)
    np.testing.assert_allclose(a.rotations, b.rotations, atol=1e-9)
    np.testing.assert_allclose(a.rest_positions, b.rest_positions, atol=1e-9)


def test_position_channels_below_the_root(body):
    """Writers that repeat the offset in the channels, and those that add to it."""
    plain = read_bvh(body).skeleton
    for value, moved in (("-10 0 0", 0.0), ("-10 3 0", 0.03), ("0 3 0", 0.03)):
        text = BODY.replace(
            "CHANNELS 3 Zrotation Xrotation Yrotation\n    JOINT rightFoot",
            "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
            "    JOINT rightFoot",
        )
        rows = [
            " ".join([*row.split()[:12], value, *row.split()[12:]])
            if len(row.split()) == 21
            else row
            for row in MOTION.splitlines()
        ]
        body.write_text(text + "\n".join(rows))
        s = read_bvh(body).skeleton
        assert s.positions[0, 3, 2] == pytest.approx(plain.positions[0, 3, 2] + moved)


def test_joints_with_axes_along_their_bones(body):
    """Without rotations one leg of such a skeleton points up: that is no rest pose."""
    plain = read_bvh(body).skeleton
    text = "HIERARCHY\nROOT mover\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n"
    text += BODY[BODY.index("ROOT hips") :].replace("ROOT", "JOINT", 1) + "}\n"
    right = text.index("rightFoot")
    text = text[:right] + text[right:].replace("OFFSET 0 -90 0", "OFFSET 0 90 0", 1)
    text = text[:right] + text[right:].replace("OFFSET 0 0 15", "OFFSET 0 0 -15", 1)
    rows = []
    for row in MOTION.splitlines():
        words = row.split()
        if len(words) == 21:  # the right leg is turned by 180 degrees about x, and its foot too
            words[:6] = [*words[:3], "0", "0", "0"]
            words[13] = "180"
            row = " ".join(["0", "0", "0", *words])
        rows.append(row)
    body.write_text(text + "\n".join(rows))
    recording = read_bvh(body)
    found = recording.skeleton
    assert any("an upright frame" in warning for warning in recording.warnings)
    assert any("1.70 m from ankle to head" in warning for warning in recording.warnings)
    rest = found.rest_positions[1:] - found.rest_positions[1]
    np.testing.assert_allclose(rest[:, 2], plain.rest_positions[:, 2], atol=1e-9)
    bones = [2, 4]  # a bone stays on its joint whatever is taken as the rest pose
    for i in bones:
        parent = found.parents[i]
        along = found.rest_positions[i] - found.rest_positions[parent]
        there = found.positions[:, parent] + found.rotations[:, parent] @ along
        np.testing.assert_allclose(there, found.positions[:, i], atol=1e-9)


def test_real_files(data):
    frames = {"07_01": 317, "09_12": 1919, "13_01": 2314, "13_11": 416}
    for path in sorted((data / "cmu_bvh").glob("*.bvh")):
        recording = read_bvh(path)
        s = recording.skeleton
        assert len(s.names) == 43
        skipped = frames[path.stem] - len(s.time)
        assert 1 <= skipped <= 6 and any("rest pose" in text for text in recording.warnings)
        assert s.time[0] == pytest.approx((skipped - 1) / 120, rel=1e-3)
        for i, parent in enumerate(s.parents):
            if parent >= 0:
                length = np.linalg.norm(s.positions[:, i] - s.positions[:, parent], axis=1)
                assert np.ptp(length) < 1e-9
        up = s.positions[:, s.names.index("head"), 2] - s.positions[:, s.names.index("lFoot"), 2]
        assert (up > 0.5).mean() > 0.9
        assert -0.05 < np.percentile(np.nanmin(s.ends[..., 2], axis=1), 5) < 0.08
        assert s.rest_positions[s.names.index("lHand"), 1] > 0.4
        # Nobody's arm turns at 2000 degrees a second at the start of these trials.
        arm = s.rotations[:, s.names.index("rShldr")]
        turn = np.einsum("nij,nij->n", arm[1:], arm[:-1])
        assert np.degrees(np.arccos(np.clip((turn - 1) / 2, -1, 1)))[:10].max() < 10
    walk = read_bvh(data / "cmu_bvh" / "07_01.bvh").skeleton
    speed = np.linalg.norm(np.gradient(walk.positions[:, 0, :2], walk.time, axis=0), axis=1)
    assert np.median(speed) == pytest.approx(1.33, abs=0.04)


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YZX"])
@pytest.mark.parametrize(
    "name",
    ["cmu_bvh/07_01.bvh", "cmu_asfamc/16_21.amc", "deepmimic/humanoid3d_jump.txt"],
)
def test_round_trip(data, tmp_path, name, order):
    read = {".bvh": read_bvh, ".amc": read_amc, ".txt": read_deepmimic}[name[-4:]]
    s = read(data / name).skeleton
    path = write_bvh(s, tmp_path / "out.bvh", order=order)
    again = read_bvh(path).skeleton
    index = [again.names.index(n) for n in s.names]
    size = np.ptp(s.rest_positions, axis=0).max()
    assert np.abs(again.positions[:, index] - s.positions).max() < 1e-4 * size
    np.testing.assert_allclose(again.rotations[:, index], s.rotations, atol=1e-5)
    if name != "deepmimic/humanoid3d_jump.txt":
        np.testing.assert_allclose(np.diff(again.time), np.diff(s.time), rtol=1e-3)


def test_cut_off_end(body):
    whole = BODY + MOTION
    body.write_text(whole[: whole.rindex("10 20") + 1])
    recording = read_bvh(body)
    assert len(recording.skeleton.time) == 2
    assert any("3 frames and holds 2" in text for text in recording.warnings)
    body.write_text(whole[: whole.rindex("10 20")] + "-")
    assert len(read_bvh(body).skeleton.time) == 2


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("MOTION\n", "", "no MOTION"),
        ("Frames: 3", "Frames: three", r"LINE: Frames is 'three'"),
        ("Frame Time: 0.01", "Frame Time: 0", r"LINE: Frame Time is 0 s"),
        ("5 90 8", "5 90 x", r"LINE, channel 3: 'x' is not a number"),
        ("5 90 8", "5 90", r"LINE: this frame has 20 numbers.* 21 channels"),
        ("OFFSET 0 70 0", "OFFSET 0 70", r"LINE: OFFSET needs 3"),
        ("CHANNELS 6 X", "CHANNELS 5 X", r"LINE: CHANNELS announces 5 and lists 6"),
        ("6 Xposition", "6 Wposition", "'Wposition' is not"),
        ("  JOINT head\n  {\n", "  JOINT head\n", "'{' is missing"),
        ("}\nMOTION", "MOTION", "'}' is missing"),
        ("HIERARCHY\nROOT hips", "HIERARCHY\nJOINT hips", "JOINT is outside"),
    ],
)
def test_bad_files(body, old, new, match):
    text = BODY + MOTION
    assert old in text
    body.write_text(text.replace(old, new, 1))
    line = text.count("\n", 0, text.index(old)) + 1
    with pytest.raises(FileError, match=match.replace("LINE", f": line {line}")):
        read_bvh(body)


def test_gaps_are_bridged(body):
    body.write_text((BODY + MOTION).replace("5 90 8", "nan 90 8"))
    recording = read_bvh(body)
    assert np.isfinite(recording.skeleton.positions).all()
    assert any("not finite" in text for text in recording.warnings)


def test_writer_refuses(data, tmp_path, body):
    s = read_bvh(body).skeleton
    with pytest.raises(ParameterError, match="order"):
        write_bvh(s, tmp_path / "x.bvh", order="ZZZ")
    with pytest.raises(FileError, match="cannot be written"):
        write_bvh(s, tmp_path / "gone" / "x.bvh")


def test_a_rest_pose_with_a_bent_spine_is_left_out(data, tmp_path):
    """Suits of sensors export the curves of the spine in the first frame."""
    plain = read_bvh(data / "cmu_bvh/07_01.bvh")
    head, rows = (data / "cmu_bvh/07_01.bvh").read_text().split("Frame Time", 1)
    clock, first, rest = rows.split("\n", 2)
    values = first.split()
    values[4::8] = ["11.0"] * len(values[4::8])
    bent = tmp_path / "bent.bvh"
    bent.write_text("\n".join([f"{head}Frame Time{clock}", " ".join(values), rest]))
    found = read_bvh(bent)
    assert any("it was left out" in warning for warning in found.warnings)
    np.testing.assert_allclose(found.skeleton.time, plain.skeleton.time)
