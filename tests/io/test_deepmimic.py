import json

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io.deepmimic import read_deepmimic

DURATION = {"walk": 1.27, "run": 0.80, "jump": 1.77, "stealthy_walk": 4.00}


@pytest.mark.parametrize("name", DURATION)
def test_motions_are_physical(data, name):
    s = read_deepmimic(data / "deepmimic" / f"humanoid3d_{name}.txt").skeleton
    assert s.time[-1] == pytest.approx(DURATION[name], abs=0.05)
    joint = s.names.index
    for side in ("left", "right"):
        thigh = s.positions[:, joint(f"{side}_knee")] - s.positions[:, joint(f"{side}_hip")]
        shank = s.positions[:, joint(f"{side}_ankle")] - s.positions[:, joint(f"{side}_knee")]
        np.testing.assert_allclose(np.linalg.norm(thigh, axis=1), 0.421546, atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(shank, axis=1), 0.409870, atol=1e-9)
        # Knees flex backwards: seen in the thigh's frame the shank points back.
        local = np.einsum("nji,nj->ni", s.rotations[:, joint(f"{side}_hip")], shank)
        bent = np.arccos(-local[:, 2] / 0.409870) > np.deg2rad(15)
        assert bent.any() and (local[bent, 0] < 0).all()
    lowest = s.ends[:, [joint("left_ankle"), joint("right_ankle")], 2].min(axis=1)
    assert -0.12 < np.percentile(lowest, 10) < 0.06
    np.testing.assert_allclose(np.linalg.det(s.rotations), 1, atol=1e-9)
    assert s.rest_positions[joint("left_hip"), 1] > 0 > s.rest_positions[joint("right_hip"), 1]


def test_walk(data):
    s = read_deepmimic(data / "deepmimic" / "humanoid3d_walk.txt").skeleton
    travel = s.positions[-1, 0] - s.positions[0, 0]
    assert travel[0] / s.time[-1] == pytest.approx(1.0, abs=0.15)  # forward is x
    assert 0.8 < s.positions[:, 0, 2].mean() < 0.95
    # Cyclic: it ends within a frame's way (a swinging foot: 3 m/s) of the pose it begins with.
    first, last = s.positions[0] - s.positions[0, 0], s.positions[-1] - s.positions[-1, 0]
    assert np.abs(first - last).max() < 3 * 0.0334


@pytest.fixture
def motion(tmp_path):
    quat = [1, 0, 0, 0]
    row = [0.1, 0, 0.9, 0, *quat, *quat, *quat, *quat, -0.5, *quat, *quat, 0.5, *quat, -0.5]
    row += [*quat, *quat, 0.5]
    path = tmp_path / "motion.txt"

    def write(change=None, keys=None):
        rows = [list(row), [0.2, *row[1:]], list(row)]
        data = {"Loop": "none", "Frames": rows, **(keys or {})}
        if change:
            change(rows)
        path.write_text(json.dumps(data))
        return path

    return write


def test_by_hand(motion):
    s = read_deepmimic(motion()).skeleton
    np.testing.assert_allclose(s.time, [0, 0.1, 0.3])
    knee, ankle = (s.positions[0, s.names.index(f"left_{n}")] for n in ("knee", "ankle"))
    np.testing.assert_allclose(knee, [0, 0.084887, 0.9 - 0.421546], atol=1e-9)
    np.testing.assert_allclose(
        ankle - knee, [-0.40987 * np.sin(0.5), 0, -0.40987 * np.cos(0.5)], atol=1e-9
    )
    elbow, wrist = (s.positions[0, s.names.index(f"left_{n}")] for n in ("elbow", "wrist"))
    assert (wrist - elbow)[0] > 0.1  # elbows flex forwards


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda rows: rows[1].pop(), r"Frames\[1\]: has 43 numbers"),
        (lambda rows: rows[1].__setitem__(7, "x"), r"Frames\[1\]\[7\]: 'x'"),
        (lambda rows: rows[1].__setitem__(7, None), r"Frames\[1\]\[7\]: 'None'"),
        (lambda rows: rows[1].__setitem__(7, float("nan")), r"Frames\[1\]\[7\]: is not finite"),
        (lambda rows: rows[1].__setitem__(0, 0), r"Frames\[1\]\[0\]: lasts 0"),
        (lambda rows: rows[2].__setitem__(4, 2), r"Frames\[2\]\[4:8\]: the quaternion of root"),
        (lambda rows: rows.__setitem__(1, 3), r"Frames\[1\]: is not a list"),
        (lambda rows: rows.clear(), r"has 0 frames"),
    ],
)
def test_bad_frames(motion, change, match):
    with pytest.raises(FileError, match=match):
        read_deepmimic(motion(change))


@pytest.mark.parametrize("text", ["{", "[]", '{"Frames": 3}', "[" * 100000, '{"Frames": [1e400]}'])
def test_bad_json(tmp_path, text):
    path = tmp_path / "x.txt"
    path.write_text(text)
    with pytest.raises(FileError):
        read_deepmimic(path)
