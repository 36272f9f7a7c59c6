"""Keypoints as JSON: three layouts, any vertical and unit; images without depth are refused."""

import json

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import format_of, read
from plantigrade.io.keypoints import read_keypoints

BODY = {
    "RHip": (0.0, 0.9, 0.1), "LHip": (0.0, 0.9, -0.1), "RKnee": (0.0, 0.5, 0.1),
    "LKnee": (0.0, 0.5, -0.1), "RAnkle": (0.0, 0.1, 0.1), "LAnkle": (0.0, 0.1, -0.1),
}  # fmt: skip
"""A person whose head points along y [m]."""
PATH = 0.05 * np.arange(5)


def points(name, scale=1.0, sign=1):
    """Positions of one point of the body, which moves along x."""
    x, y, z = BODY[name]
    return [[scale * (x + step), sign * scale * y, scale * z] for step in PATH]


def ours(**says):
    return {"fps": 50, "unit": "m", "keypoints": {name: points(name) for name in BODY}} | says


def of_mmpose():
    frames = [
        {"frame_id": k, "instances": [{"keypoints": [points(name)[k] for name in BODY]}]}
        for k in range(len(PATH))
    ]
    names = {str(k): name for k, name in enumerate(BODY)}
    return {"meta_info": {"keypoint_id2name": names}, "instance_info": frames}


def by_frame():
    return [{name: points(name)[k] for name in BODY} for k in range(len(PATH))]


def written(tmp_path, data):
    path = tmp_path / "walk.json"
    path.write_text(json.dumps(data) if not isinstance(data, str) else data)
    return path


@pytest.mark.parametrize("layout", [ours, of_mmpose, by_frame])
def test_every_layout_is_recognised_and_upright(tmp_path, layout):
    path = written(tmp_path, layout())
    assert format_of(path).name == "keypoints"
    markers = read(path).markers
    assert set(markers.names) == set(BODY)
    hip = markers.positions[:, markers.index("RHip")]
    np.testing.assert_allclose(hip[:, 2], 0.9)
    np.testing.assert_allclose(hip[:, 0], PATH, atol=1e-12)


def test_camera_axes_point_down_and_millimetres_are_seen(tmp_path):
    data = {"keypoints": {name: points(name, 1e3, -1) for name in BODY}}
    recording = read(written(tmp_path, data))
    markers = recording.markers
    hip, ankle = (markers.positions[0, markers.index(n), 2] for n in ("RHip", "RAnkle"))
    assert hip - ankle == pytest.approx(0.8)
    assert any("30 frames per second" in said for said in recording.warnings)


def test_a_missing_point_is_a_gap(tmp_path):
    data = ours()
    data["keypoints"]["RKnee"][2] = None
    markers = read(written(tmp_path, data)).markers
    assert np.isnan(markers.positions[2, markers.index("RKnee")]).all()


def test_the_rate_can_be_given(tmp_path):
    assert read(written(tmp_path, ours()), rate=25).markers.rate == pytest.approx(25)


def flat(data):
    data["keypoints"] = {name: [p[:2] for p in row] for name, row in data["keypoints"].items()}


def still(data):
    data["keypoints"] = {name: row[:1] * len(row) for name, row in data["keypoints"].items()}


def empty(data):
    data["keypoints"] = {name: [None] * len(row) for name, row in data["keypoints"].items()}


def zeros(data):
    data["keypoints"] = {n: [[0, 0, 0]] * len(row) for n, row in data["keypoints"].items()}


def one_frame_less(data):
    data["keypoints"]["RHip"].pop()


def word(data):
    data["keypoints"]["RHip"][3] = "here"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (flat, "2-D"),
        (still, "middle of the hips"),
        (empty, "no point of any keypoint"),
        (zeros, "no point of any keypoint"),
        (one_frame_less, "4, 5 frames"),
        (word, "frame 3"),
        (lambda data: data.update(fps=0), "fps"),
        (lambda data: data.update(unit="ell"), "ell"),
        (lambda data: data.update(up="w"), "up"),
    ],
)
def test_what_is_no_person_in_space_is_refused(tmp_path, change, said):
    data = ours()
    change(data)
    with pytest.raises(FileError, match=said):
        read_keypoints(written(tmp_path, data))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"people": [{"pose_keypoints_2d": [1, 2, 0.9]}]}', "2-D"),
        ('{"keypoints": ', "not JSON"),
        ('{"keypoints": 3}', "by name"),
        ('[{"keypoints": [1, 2, 3]}]', "without names"),
        ('{"instance_info": [], "keypoints": 1}', "name its keypoints"),
    ],
)
def test_damaged_files_end_in_one_sentence(tmp_path, text, said):
    with pytest.raises(FileError, match=said) as found:
        read(written(tmp_path, text))
    assert "\n" not in str(found.value)
