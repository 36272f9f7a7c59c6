"""What belongs to a recording is found by name and content, and nothing else is."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from plantigrade.io import read, write
from plantigrade.io.companions import find_companions, is_still, same_person
from plantigrade.motion import ForcePlate, Markers, Recording, Subject, Table

TIME = np.arange(120) / 100
NAMES = ("LASI", "RASI", "LPSI", "RPSI", "LKNE", "RKNE", "LANK", "RANK")


def body(size: float = 1.0) -> np.ndarray:
    """Marker places of a stick person of a size [m]."""
    rows = [
        (0.1, 0.12, 1.0), (0.1, -0.12, 1.0), (-0.1, 0.05, 1.02), (-0.1, -0.05, 1.02),
        (0.0, 0.15, 0.5), (0.0, -0.15, 0.5), (0.0, 0.12, 0.1), (0.0, -0.12, 0.1),
    ]  # fmt: skip
    return size * np.array(rows)


def standing(path: Path, *, size: float = 1.0, names=NAMES, subject=None) -> Path:
    """Write a standing trial."""
    sway = 0.003 * np.sin(np.outer(TIME, np.ones(3)))[:, None]
    x = body(size)[None, : len(names)] + sway
    write(Recording(path, Markers(names, TIME, x), subject=subject or Subject()), path)
    return path


def walking(path: Path, *, subject=None, frames: int = len(TIME)) -> Path:
    """Write a walk: the pelvis goes ahead, the legs swing about it."""
    time = np.arange(frames) / 100
    x = np.tile(body(), (frames, 1, 1))
    swing = 0.3 * np.sin(2 * np.pi * time)
    x[:, 4:, 0] += np.outer(swing, [1, -1, 1, -1])
    x[..., 0] += 1.2 * time[:, None]
    write(Recording(path, Markers(NAMES, time, x), subject=subject or Subject()), path)
    return path


def forces(path: Path, *, start: float = 0.0) -> Path:
    """Write a file of ground reactions."""
    time = start + np.arange(1200) / 1000
    push = np.tile([0.0, 0.0, 700.0], (len(time), 1))
    plates = tuple(
        ForcePlate(
            f"ground_force_{s}", time, push, np.zeros((len(time), 3)), np.zeros(len(time)), side=s
        )
        for s in "rl"
    )
    write(Recording(path, plates=plates), path)
    return path


def coordinates(path: Path) -> Path:
    """Write a motion of joint coordinates."""
    names = ("pelvis_tilt", "hip_flexion_r", "knee_angle_r", "hip_flexion_l", "knee_angle_l")
    write(Recording(path, coordinates=Table(names, TIME, np.ones((len(TIME), 5)))), path)
    return path


def found(path: Path) -> tuple[str | None, str | None]:
    """Names of the standing trial and the file of forces found beside a recording."""
    companions = find_companions(read(path), read)
    static, source = companions.static, companions.forces_source
    return static and static.source.name, source and source.name


@pytest.mark.parametrize("ending", ["trc", "c3d"])
@pytest.mark.parametrize(
    ("walk", "static"),
    [
        ("subject01_walk1", "subject01_static"),
        ("subject01_walk1", "subject01_CAL"),
        ("S3Walk", "S3Standing"),
        ("anything", "static"),
        ("HC038A11", "HC038A01"),
        ("Walk03", "Static01"),
        ("subject01_walk1", "subject01_static_2"),
        ("P07_gait_12", "P07_cal03"),
    ],
)
def test_static_trial_is_found_by_name_and_content(tmp_path, walk, static, ending):
    path = walking(tmp_path / f"{walk}.{ending}")
    standing(tmp_path / f"{static}.{ending}")
    assert found(path) == (f"{static}.{ending}", None)


def test_a_standing_trial_is_found_behind_many_numbered_walks(tmp_path):
    for number in range(1, 20):
        walking(tmp_path / f"S07_{number:02d}.c3d", frames=240)
    standing(tmp_path / "S07_20.c3d")
    assert found(tmp_path / "S07_01.c3d")[0] == "S07_20.c3d"


@pytest.mark.parametrize("name", ["subject02_static", "subject02_static1", "other", "HC032A01"])
def test_a_name_of_another_person_is_no_companion(tmp_path, name):
    path = walking(tmp_path / "subject01_walk1.trc")
    standing(tmp_path / f"{name}.trc")
    assert found(path) == (None, None)


def test_a_name_alone_is_not_enough(tmp_path):
    path = walking(tmp_path / "subject01_walk1.trc")
    walking(tmp_path / "subject01_static.trc")  # moves
    assert found(path) == (None, None)
    standing(tmp_path / "subject01_static.trc", names=("A", "B", "C", "D", "E"))  # other markers
    assert found(path) == (None, None)


def test_a_body_of_another_size_is_no_companion(tmp_path):
    path = walking(tmp_path / "trial2.trc")
    standing(tmp_path / "trial1.trc", size=1.06)
    assert found(path) == (None, None)
    standing(tmp_path / "trial1.trc", size=1.01)
    assert found(path) == ("trial1.trc", None)


def test_another_stature_in_the_file_is_another_person(tmp_path):
    path = walking(tmp_path / "trial2.c3d", subject=Subject(height=1.74, mass=57.0))
    standing(tmp_path / "trial1.c3d", subject=Subject(height=1.58, mass=60.0))
    assert found(path) == (None, None)


def test_a_standing_trial_needs_none_itself(tmp_path):
    path = standing(tmp_path / "static.trc")
    standing(tmp_path / "static2.trc")
    assert is_still(read(path))
    assert found(path) == (None, None)


@pytest.mark.parametrize(
    ("motion", "grf", "belongs"),
    [
        ("walk1", "walk1_grf", True),
        ("walk1_ik", "walk1_grf", True),
        ("std_subject01_walk1_ik", "subject01_walk1_grf", True),
        ("coordinates", "grf_walk", True),
        ("markers_walk", "grf_walk", True),
        ("normal_gait", "subject01_walk1_grf", False),
        ("walk1", "walk2_grf", False),
        ("walk1", "walk10_grf", False),
        ("walk_1", "walk_grf", False),  # of which walk?
        ("subject01_walk1", "subject01_grf", False),
        ("subject01_walk1", "subject02_walk1_grf", False),
        ("walk1", "grf", False),
    ],
)
def test_forces_are_found_by_the_shared_name(tmp_path, motion, grf, belongs):
    path = coordinates(tmp_path / f"{motion}.mot")
    forces(tmp_path / f"{grf}.mot")
    assert found(path) == (None, f"{grf}.mot" if belongs else None)


def test_the_name_itself_comes_before_one_alike(tmp_path):
    path = coordinates(tmp_path / "walk1_slow.mot")
    forces(tmp_path / "walk1_slow_grf.mot")
    forces(tmp_path / "walk1_grf.mot")
    assert found(path) == (None, "walk1_slow_grf.mot")


def test_two_that_may_belong_are_a_doubt(tmp_path):
    path = coordinates(tmp_path / "coordinates.mot")
    forces(tmp_path / "grf_a.mot")
    forces(tmp_path / "grf_b.mot")
    assert found(path) == (None, None)


def test_forces_of_another_time_do_not_belong(tmp_path):
    path = coordinates(tmp_path / "walk1.mot")
    forces(tmp_path / "walk1_grf.mot", start=10.0)
    assert found(path) == (None, None)


def test_a_force_name_without_forces_is_no_companion(tmp_path):
    path = coordinates(tmp_path / "walk1.mot")
    coordinates(tmp_path / "walk1_grf.mot")
    assert found(path) == (None, None)


def test_unreadable_neighbours_are_passed_over(tmp_path):
    path = walking(tmp_path / "subject01_walk1.trc")
    for name in ("subject01_static.trc", "subject01_walk1_grf.mot", "subject01_cal.trc"):
        (tmp_path / name).write_bytes(b"\x00\xff nonsense")
    (tmp_path / "subject01_stand.trc").symlink_to(tmp_path / "nowhere")
    (tmp_path / "static.trc").mkdir()
    assert found(path) == (None, None)
    standing(tmp_path / "subject01_standing.trc")
    forces(tmp_path / "subject01_walk1_forces.mot")
    assert found(path) == ("subject01_standing.trc", "subject01_walk1_forces.mot")


def test_the_recordings_own_folder_is_searched_not_the_working_one(tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    path = walking(tmp_path / "there" / "walk.trc")
    standing(tmp_path / "static.trc")
    monkeypatch.chdir(tmp_path)
    assert found(Path("there") / "walk.trc") == (None, None)
    assert path.exists()


PUBLIC = {
    "c3d/HC038A11.c3d": ("HC038A01.c3d", None),
    "c3d/HC032A03.c3d": ("HC032A01.c3d", None),
    "c3d/opensim_walking2.c3d": (None, None),
    "opensim/rajagopal_walk/markers_walk.trc": (None, "grf_walk.mot"),
    "opensim/gait2392_subject01/subject01_walk1.trc": (
        "subject01_static.trc",
        "subject01_walk1_grf.mot",
    ),
    "opensim/gait2392_subject01/std_subject01_walk1_ik.mot": (None, "subject01_walk1_grf.mot"),
    "opensim/gait2392_subject01/normal_gait.mot": (None, None),
    "opensim/gait2392_subject01/crouch_gait.mot": (None, None),
    "opensim/opencap_squat/squats1_videoAndMocap.mot": (None, None),
}


@pytest.mark.parametrize("name", PUBLIC)
def test_public_recordings(data, name):
    assert found(data / name) == PUBLIC[name]


def test_two_persons_are_distinguished(data):
    a, b = data / "c3d/HC038A11.c3d", data / "c3d/HC032A01.c3d"
    bare = [Recording(p, read(p).markers) for p in (a, b)]  # without their statures
    assert not same_person(*bare)
    own = read(data / "c3d/HC038A01.c3d")
    assert same_person(bare[0], Recording(own.source, own.markers))


def test_renamed_copies_in_one_folder(data, tmp_path):
    for source, name in (("HC038A11", "P1"), ("HC032A01", "P2"), ("HC038A01", "P3")):
        shutil.copy(data / "c3d" / f"{source}.c3d", tmp_path / f"{name}.c3d")
    assert found(tmp_path / "P1.c3d") == ("P3.c3d", None)
