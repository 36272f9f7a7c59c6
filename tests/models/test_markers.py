"""Marker names: spellings, built-in sets, and a user's own set with all that can be wrong in it."""

import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound, FileError, ParameterError
from plantigrade.models.landmarks import attachments, landmarks
from plantigrade.models.markers import (
    MARKER_SETS,
    MarkerSet,
    best_set,
    landmark_of,
    place_markers,
    read_marker_set,
)
from tests.models.presets import PRESETS, person


@pytest.mark.parametrize(
    "name",
    [
        "R.ASIS",
        "RASI",
        "R_ASIS",
        "ASIS_R",
        "RIAS",
        "asis_r",
        "R ASIS",
        "RASIS",
        "Right_ASIS",
        "r-asi",
    ],
)
def test_one_point_many_spellings(name):
    assert landmark_of(name) == "asis_r"


@pytest.mark.parametrize(
    ("name", "mark"),
    [
        ("LKNE", "knee_lateral_l"),
        ("L.Knee.Lat", "knee_lateral_l"),
        ("LFLE", "knee_lateral_l"),
        ("R_knee_medial", "knee_medial_r"),
        ("RFME", "knee_medial_r"),
        ("RLM", "ankle_lateral_r"),
        ("LLM", "ankle_lateral_l"),
        ("RMM", "ankle_medial_r"),
        ("RANK", "ankle_lateral_r"),
        ("LHEE", "heel_l"),
        ("R_HEEL", "heel_r"),
        ("RCAL", "heel_r"),
        ("RMT5", "metatarsal_5_head_r"),
        ("LFM1", "metatarsal_1_head_l"),
        ("R.MT2", "metatarsal_2_head_r"),
        ("LACR", "acromion_l"),
        ("RSHO", "acromion_r"),
        ("LPSIS", "psis_l"),
        ("RGT", "trochanter_r"),
        ("LeftHeel", "heel_l"),
        ("SACR", "sacrum"),
        ("C7", "c7"),
        ("CV7", "c7"),
        ("T10", "t10"),
        ("CLAV", "suprasternale"),
        ("STRN", "xiphoid"),  # Plug-in Gait puts it on the xiphoid process
        ("L3", "l3"),  # a vertebra, not a left third of something
        ("R_HJC", "hip_joint_r"),
    ],
)
def test_common_names(name, mark):
    assert landmark_of(name) == mark


@pytest.mark.parametrize(
    "name", ["RTH2", "marker12", "*110", "", "R", "L", "XYZ", "force1", "RTIA1", "C_7_x_9", "🦶"]
)
def test_names_nobody_knows(name):
    assert landmark_of(name) is None


@pytest.mark.parametrize(
    "name", ["RKneeAngles", "LHipMoment", "RGroundReactionForce", "CentreOfMass", "LAnklePower"]
)
def test_computed_outputs_are_no_markers(name):
    assert landmark_of(name) is None


@pytest.mark.parametrize("name", ["RFEP", "RFEO", "PELA", "LTIL", "RTBO", "LCLP"])
def test_virtual_points_of_segments_are_no_markers(name):
    """Plug-in Gait writes the corners of its segments among the markers: RFEP, RFEO, RFEL …"""
    assert landmark_of(name) is None


@pytest.mark.parametrize("marker_set", MARKER_SETS.values(), ids=lambda s: s.name)
def test_built_in_sets_name_landmarks_that_exist(marker_set):
    known = set(landmarks(person("42", "rigid").dimensions))
    assert set(marker_set.landmarks.values()) <= known
    for name, mark in marker_set.landmarks.items():
        if name.upper().startswith("R") and mark.endswith(("_r", "_l")):
            assert mark.endswith("_r"), name
        if name.upper().startswith("L") and mark.endswith(("_r", "_l")):
            assert mark.endswith("_l"), name


@pytest.mark.parametrize("marker_set", MARKER_SETS.values(), ids=lambda s: s.name)
def test_a_set_recognises_itself_and_places_all_its_markers(marker_set):
    names = list(marker_set.landmarks)
    assert set(names) <= set(best_set(names).landmarks)
    for joints, feet in PRESETS:
        human = person(joints, feet)
        placed = place_markers(names, human)
        assert list(placed) == names
        for name, place in placed.items():
            assert place is not None and place.body in human.body_names, name


def test_the_spelling_helps_where_the_set_does_not_know():
    human = person("42", "rigid")
    placed = place_markers(["LASI", "RASI", "R_FIBULA", "nobody"], human)
    np.testing.assert_allclose(
        placed["R_FIBULA"].position, attachments(human)["fibula_head_r"].position
    )
    assert placed["nobody"] is None


GOOD = """
name = "my lab"
[markers]
RKN1 = "knee_lateral_r"
RTH7 = { body = "femur_r", position = [0.05, -0.09, -0.2] }
"""


def test_a_users_own_set(tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text(GOOD)
    mine = read_marker_set(path)
    assert mine == MarkerSet(
        "my lab", {"RKN1": "knee_lateral_r"}, {"RTH7": ("femur_r", (0.05, -0.09, -0.2))}
    )
    human = person("42", "rigid")
    placed = place_markers(["RKN1", "RTH7", "LASI"], human, mine)
    np.testing.assert_allclose(placed["RTH7"].position, [0.05, -0.09, -0.2])
    assert placed["RTH7"].body == "femur_r"
    assert placed["RKN1"].body == "femur_r"
    assert placed["LASI"].body == "pelvis"  # by its spelling


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[markers", "is not a TOML file"),
        ("name = 'x'", "has no \\[markers\\] table"),
        ("[markers]", "has no \\[markers\\] table"),
        ("markers = 3", "has no \\[markers\\] table"),
        ("[markers]\nRKNE = 3", "marker RKNE: 3 is not an attachment"),
        ("[markers]\nA = { body = 'femur_r' }", "is not an attachment"),
        ("[markers]\nA = { body = 'femur_r', position = [1, 2] }", "is not an attachment"),
        ("[markers]\nA = { body = 'femur_r', position = ['a', 1, 2] }", "is not an attachment"),
        ("[markers]\nA = { body = 'femur_r', position = [nan, 1, 2] }", "is not an attachment"),
        (
            "[markers]\nA = { body = 'femur_r', position = [true, 1, 2] }",
            "is not an attachment",
        ),
    ],
)
def test_what_can_be_wrong_in_a_users_set(tmp_path, text, message):
    path = tmp_path / "lab.toml"
    path.write_text(text)
    with pytest.raises(FileError, match=message) as caught:
        read_marker_set(path)
    assert "lab.toml" in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileError, match="cannot be read"):
        read_marker_set(tmp_path / "none.toml")
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(FileError, match="is not a TOML file"):
        read_marker_set(binary)


def test_a_set_that_names_what_does_not_exist_is_refused():
    human = person("42", "rigid")
    with pytest.raises(ParameterError, match="puts A on 'kneecap'.*knee_lateral_r"):
        place_markers(["A"], human, MarkerSet("s", {"A": "kneecap"}, {}))
    with pytest.raises(CoordinateNotFound, match="no body 'wing_r'"):
        place_markers(["A"], human, MarkerSet("s", {}, {"A": ("wing_r", (0.0, 0.0, 0.0))}))
