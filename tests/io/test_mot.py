import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.io.mot import read_mot, read_table, write_mot
from plantigrade.io.opensim_coordinates import knee_sign
from plantigrade.motion import ForcePlate, Recording, Table

GRAVITY = 9.81


def mot(path, names, rows, *head, sep="\t"):
    lines = ["name", "version=1", *head, "endheader", sep.join(names)]
    lines += [
        sep.join(f"{x:.12g}" if isinstance(x, float) else str(x) for x in row) for row in rows
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def path(tmp_path):
    return tmp_path / "x.mot"


# ------------------------------------------------------------------------------- coordinates


@pytest.mark.parametrize(
    "name",
    [
        "rajagopal_walk/coordinates.sto",
        "gait2392_subject01/std_subject01_walk1_ik.mot",
        "gait2392_subject01/normal_gait.mot",
        "gait2392_subject01/subject01_walk_IK_10dof.mot",
        "moco_2d_walking/referenceCoordinates.sto",
        "opencap_squat/squats1_videoAndMocap.mot",
        "gait2392_subject01/crouch_gait.mot",
    ],
)
def test_real_coordinates_are_human(data, name):
    recording = read_mot(data / "opensim" / name)
    c = recording.coordinates
    assert c is not None and not recording.plates
    for side in "rl":
        knee = np.rad2deg(c[f"knee_angle_{side}"])
        assert knee.min() > -15 and 10 < knee.max() < 110  # flexion positive, in all families
        hip = np.rad2deg(c[f"hip_flexion_{side}"])
        assert hip.min() > -45 and 5 < hip.max() < 125
        assert np.abs(np.rad2deg(c[f"ankle_angle_{side}"])).max() < 45
    assert 0.75 < c["pelvis_ty"].mean() < 1.15  # a height in metres, never scaled
    assert not any("/" in n or n.endswith("_beta") for n in c.names)
    assert (np.diff(c.time) > 0).all()


def test_knee_flexes_in_swing(data):
    """The peak of knee flexion in normal gait is about 60 degrees and in swing."""
    c = read_mot(data / "opensim" / "gait2392_subject01" / "normal_gait.mot").coordinates
    knee = np.rad2deg(c["knee_angle_r"])
    assert 50 < knee.max() < 70
    assert 0.65 < c.time[np.argmax(knee)] / c.time[-1] < 0.8


def test_degrees_scale_rotations_only(path):
    names = ["time", "pelvis_tx", "pelvis_tilt", "knee_angle_r", "knee_angle_r_beta"]
    rows = [[0.0, 1.5, 10.0, 30.0, 0.5], [0.1, 1.6, 20.0, 60.0, 1.0]]
    c = read_mot(mot(path, names, rows, "inDegrees=yes")).coordinates
    assert c.names == ("pelvis_tx", "pelvis_tilt", "knee_angle_r")
    np.testing.assert_allclose(c["pelvis_tx"], [1.5, 1.6])
    np.testing.assert_allclose(c["knee_angle_r"], np.deg2rad([30, 60]))
    table = read_table(path)
    np.testing.assert_allclose(table["knee_angle_r_beta"], [0.5, 1.0])
    same = read_mot(mot(path, names, rows, "inDegrees=no")).coordinates  # nobody has 60 rad
    np.testing.assert_allclose(same.values, c.values)
    rows = np.array(rows) * [1, 1, np.pi / 180, np.pi / 180, 1]
    for head in (("inDegrees=no",), ()):
        same = read_mot(mot(path, names, rows.tolist(), *head)).coordinates
        np.testing.assert_allclose(same.values, c.values)


def test_moments_are_never_scaled(data):
    path = data / "opensim" / "rajagopal_walk" / "id_walk.sto"
    table = read_table(path)
    assert np.abs(table["ankle_angle_r_moment"]).max() > 80  # [N m], push-off
    with pytest.raises(FileError, match=r"neither joint coordinates nor ground reactions.*give a"):
        read_mot(path)


def test_new_paths(path):
    names = [
        "time",
        "/jointset/hip_r/hip_flexion_r/value",
        "/jointset/hip_r/hip_flexion_r/speed",
        "/forceset/soleus_r/activation",
        "hip_l/hip_flexion_l/value",
        "hip_l/hip_flexion_l/speed",
    ]
    c = read_mot(
        mot(path, names, [[0.0, 0.1, 9, 9, 0.2, 9], [0.1, 0.1, 9, 9, 0.2, 9]], "inDegrees=no")
    ).coordinates
    assert c.names == ("hip_flexion_r", "hip_flexion_l")
    assert len(read_table(path).names) == 5


def test_knee_sign():
    assert knee_sign(np.deg2rad(np.array([[5.0, 60.0]]))) == 1
    assert knee_sign(np.deg2rad(np.array([[5.0, -60.0]]))) == -1
    assert knee_sign(np.deg2rad(np.array([[-5.0, -15.0]]))) == -1  # slightly bent standing
    assert knee_sign(np.deg2rad(np.array([[-1.0, 1.0]]))) == 1
    assert knee_sign(np.full((3, 2), np.nan)) == 1


def test_knee_sign_by_option(path):
    mot(path, ["time", "knee_angle_r"], [[0.0, -5.0], [0.1, -8.0]], "inDegrees=yes")
    recording = read_mot(path)
    assert recording.coordinates.values.min() > 0 and "negative" in recording.warnings[0]
    assert read_mot(path, knee_sign=1).coordinates.values.max() < 0
    with pytest.raises(ParameterError, match="knee_sign"):
        read_mot(path, knee_sign=2)


# --------------------------------------------------------------------------- ground reactions


def test_real_forces_carry_the_body(data):
    """Mean vertical force over the walking cycle is body weight; feet are where the plates say."""
    folder = data / "opensim"
    plates = read_mot(folder / "gait2392_subject01" / "subject01_walk1_grf.mot").plates
    assert [plate.name for plate in plates] == ["ground_force", "1_ground_force"]
    time = plates[0].time
    cycle = (time >= 0.622) & (time < 1.855)
    weight = sum(plate.force[cycle, 2].mean() for plate in plates)
    assert weight / GRAVITY == pytest.approx(72.6, rel=0.05)
    right, left = read_mot(folder / "rajagopal_walk" / "grf_walk.mot").plates
    assert (right.side, left.side) == ("r", "l")
    # Walking along +x, the left foot lies further left than the right one.
    assert np.nanmedian(left.cop[:, 1]) > np.nanmedian(right.cop[:, 1]) + 0.05
    assert 800 < right.force[:, 2].max() < 1100 and right.force[:, 2].min() > -5
    loaded = right.force[:, 2] > 10
    assert np.isfinite(right.cop[loaded]).all() and np.isnan(right.cop[~loaded]).all()
    stance = (right.time > 0.3) & (right.time < 1.0)
    x = right.cop[stance, 0]
    assert 0.15 < x[-1] - x[0] < 0.35  # heel to toe
    # It brakes first and pushes off last.
    assert right.force[stance, 0][:300].mean() < 0 < right.force[stance, 0][-500:].mean()
    assert np.abs(right.free_moment).max() < 20
    for plate in read_mot(folder / "moco_2d_walking" / "referenceGRF.sto").plates:
        assert np.isnan(plate.cop).all()  # the file gives none


FAMILIES = [
    ("ground_force_v{}", "ground_force_p{}", "ground_torque_{}", "ground_force", None),
    ("1_ground_force_v{}", "1_ground_force_p{}", "1_ground_torque_{}", "1_ground_force", None),
    ("ground_force_l_v{}", "ground_force_l_p{}", "ground_torque_l_{}", "ground_force_l", "l"),
    ("ground_force_1_v{}", "ground_force_1_p{}", "ground_force_1_m{}", "ground_force_1", None),
    ("ground_force_1_v{}", "ground_force_1_p{}", "ground_moment_1_m{}", "ground_force_1", None),
    ("calcn_r_force_v{}", "calcn_r_force_p{}", "calcn_r_torque_{}", "calcn_r_force", "r"),
    ("FP2_v{}", "FP2_p{}", "FP2_m{}", "FP2", None),
]


@pytest.mark.parametrize("family", FAMILIES)
def test_wrench_is_kept_whatever_the_names(path, family):
    """Force at the centre of pressure plus free moment is the same wrench as the file's."""
    rng = np.random.default_rng(5)
    f = rng.uniform([-100, 300, -50], [100, 900, 50], (6, 3))
    p = rng.uniform([0, 0, -0.3], [1, 0, 0.3], (6, 3))
    t = rng.uniform(-20, 20, (6, 3))
    f[2] = 0
    columns = ["time", *(pattern.format(x) for pattern in family[:3] for x in "xyz")]
    rows = np.concatenate([np.arange(6)[:, None] * 0.1, f, p, t], axis=1)
    (plate,) = read_mot(mot(path, columns, rows.tolist())).plates
    assert (plate.name, plate.side) == family[3:]
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # x forward, y up, z right to ours
    f, p, t = f @ turn.T, p @ turn.T, t @ turn.T
    np.testing.assert_allclose(plate.force, f, atol=1e-8)
    assert np.isnan(plate.cop[2]).all()
    good = [0, 1, 3, 4, 5]
    about_origin = np.cross(p, f) + t
    ours = np.cross(plate.cop, f)
    ours[:, 2] += plate.free_moment
    np.testing.assert_allclose(ours[good], about_origin[good], atol=1e-6)


def test_forces_that_push_down_and_millimetres(path):
    columns = ["time", *(f"ground_force_{q}{x}" for q in "vp" for x in "xyz")]
    rows = [[0.1 * i, 0.0, -500.0, 0.0, 1000.0, 0.0, 100.0] for i in range(4)]
    recording = read_mot(mot(path, columns, rows))
    plate = recording.plates[0]
    assert (plate.force[:, 2] > 0).all()
    np.testing.assert_allclose(plate.cop[0], [1.0, -0.1, 0.0])
    assert len(recording.warnings) == 2


# --------------------------------------------------------------------------------- writing


def test_coordinates_round_trip(data, path):
    source = read_mot(data / "opensim" / "rajagopal_walk" / "coordinates.sto")
    for in_degrees in (True, False):
        write_mot(source, path, in_degrees=in_degrees)
        again = read_mot(path).coordinates
        assert again.names == source.coordinates.names
        np.testing.assert_allclose(again.values, source.coordinates.values, atol=1e-9)
        np.testing.assert_allclose(again.time, source.coordinates.time)
    text = write_mot(source, path).read_text()
    assert "inDegrees=yes" in text and "nRows=1350" in text and "nColumns=30" in text


def test_forces_round_trip(data, path):
    for name in ("rajagopal_walk/grf_walk.mot", "gait2392_subject01/subject01_walk1_grf.mot"):
        source = read_mot(data / "opensim" / name).plates
        again = read_mot(write_mot(source, path)).plates
        for a, b in zip(source, again, strict=True):
            assert a.side == b.side
            np.testing.assert_allclose(a.force, b.force, atol=1e-6)
            np.testing.assert_allclose(a.cop, b.cop, atol=1e-6)
            np.testing.assert_allclose(a.free_moment, b.free_moment, atol=1e-6)


def test_forces_on_other_clocks_are_interpolated(path):
    def plate(n, side):
        time = np.linspace(0, 1, n)
        force = np.tile([0.0, 0, 500], (n, 1))
        return ForcePlate("p", time, force, np.zeros((n, 3)) + 0.1, np.ones(n), side=side)

    plates = read_mot(write_mot([plate(11, "r"), plate(101, "l")], path)).plates
    assert len(plates[1].time) == 11
    np.testing.assert_allclose(plates[1].cop, 0.1)


def test_nothing_to_write(path, tmp_path):
    with pytest.raises(ParameterError, match="neither"):
        write_mot(Recording(source=path), path)
    table = Table(("pelvis_tx",), np.zeros(1), np.zeros((1, 1)))
    with pytest.raises(FileError, match="cannot be written"):
        write_mot(table, tmp_path / "gone" / "x.mot")


# --------------------------------------------------------------------------------- bad input

GOOD = [[0.0, 1.0, 2.0], [0.1, 1.0, 2.0], [0.2, 1.0, 2.0]]
NAMES = ["time", "knee_angle_r", "hip_flexion_r"]


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("endheader", "", "no line 'endheader'"),
        ("time", "frame", r"line 4: the first column is 'frame'"),
        ("0.1\t1\t2", "0.1\t1", r"line 6"),
        ("0.1\t1\t2", "0.1\t1\tx", r"line 6.*'x' is not a number"),
        ("0.1\t1", "-1\t1", r"row 2, column time: time decreases"),
        ("0.1\t1", "nan\t1", r"row 2, column time"),
        ("version=1", "DataType=Vec3", "DataType=Vec3"),
    ],
)
def test_bad_files(path, old, new, match):
    text = mot(path, NAMES, GOOD).read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FileError, match=match):
        read_mot(path)


def test_no_rows(path):
    mot(path, NAMES, [])
    with pytest.raises(FileError, match="no rows"):
        read_mot(path)
    path.write_text("a\nendheader\n")
    with pytest.raises(FileError, match="after its header"):
        read_mot(path)


def test_cut_off_gaps_and_repeats(path):
    text = mot(path, NAMES, GOOD, "nRows=3", "inDegrees=yes").read_text()
    path.write_text(text[: text.rindex("\t")])
    recording = read_mot(path)
    assert len(recording.coordinates.time) == 2
    assert any("truncated" in w for w in recording.warnings)
    path.write_text(text.replace("0.1\t1\t2", "0.1\t\t2"))
    assert np.isnan(read_mot(path).coordinates["knee_angle_r"][1])
    path.write_text(text.replace("0.1\t", "0\t"))
    assert len(read_mot(path).coordinates.time) == 2
    path.write_text(text.replace("\t", "  "))
    assert len(read_mot(path).coordinates.time) == 3
    path.write_text(text.replace("\n", "\t\t\n"))
    assert len(read_mot(path).coordinates.time) == 3
    path.write_text(text.replace("\n", "\r\n"))
    assert len(read_mot(path).coordinates.time) == 3
