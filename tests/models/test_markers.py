"""Marker names: spellings, built-in sets, and valid and invalid user sets."""

import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound, FileError, ParameterError
from plantigrade.models.landmarks import attachments, landmarks
from plantigrade.models.markers import (
    MARKER_SETS,
    MarkerSet,
    best_set,
    landmark_names,
    landmark_of,
    place_markers,
    read_marker_set,
)
from plantigrade.models.spellings import MIDLINE, SPELLINGS
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


SETS = {
    "CGM2": "LASI RPSI LKNM LMED LSMH LFMH LVMH T2 LTOE",
    "Helen Hayes": "L.ASIS V.Sacral L.Knee.Medial L.Ankle.Medial R.Offset Front.Head L.Toe",
    "CAST": "LASIS RPSIS LME LMM LSM LFM LVM LGT LHF LTT LLE LCA",
    "CMU, 41 markers": "LFWT RBWT RBAC LSHN LMT5 LFIN LWRA LWRB CLAV STRN C7 LTOE",
    "KIT": "LAEL LAOL LWTS LWPS LHTS LHPS L3 LASI RPSI",
    "Rizzoli, Qualisys": "LIAS RIPS LFLE LFME LFAX LTTC LFAL LTAM LFCC LFMT LSMT LVMT "
    "LFM1 LFM2 LFM5 SJN SXS CV7 MAI LSAE LHLE LRSP LUSP LHM2",
    "Human Body Model": "LGTRO LLKE LLM LLEE LMEE LLW LMW XYPH THEAD LHEAD SACR FHEAD LATI",
    "OptiTrack": "WaistLFront LKneeOut LKneeIn LAnkleOut LToeIn LToeOut BackTop LShoulderTop",
    "OpenCap": "r.ASIS_study L.PSIS_study L_knee_study L_mknee_study L_ankle_study "
    "L_mankle_study L_toe_study L_5meta_study L_calc_study L_lelbow_study L_lwrist_study "
    "L_lknee_study C7_study LHJC_study",
    "Xsens": "pLeftASI pSacrum jLeftKnee pLeftKneeLatEpicondyle pLeftKneeMedEpicondyle "
    "pLeftLatMalleolus pLeftMedMalleolus pLeftHeelFoot pLeftToe pC7SpinalProcess pIJ pPX jL5S1 "
    "pLeftRadialStyloid pLeftUlnarStyloid pLeftOlecranon pTopOfHead",
    "Cortex and others": "VSAC SNJ LIWR LOWR L_INWRIST L_OUTWRIST L_F_WAIST R_B_WAIST",
}
MARKS = {
    "CGM2": "asis_l psis_r knee_medial_l ankle_medial_l metatarsal_2_head_l metatarsal_1_head_l "
    "metatarsal_5_head_l t2 metatarsal_2_head_l",
    "Helen Hayes": "asis_l sacrum knee_medial_l ankle_medial_l scapula_r forehead "
    "metatarsal_2_head_l",
    "CAST": "asis_l psis_r knee_medial_l ankle_medial_l metatarsal_2_head_l metatarsal_1_head_l "
    "metatarsal_5_head_l trochanter_l fibula_head_l tibial_tuberosity_l knee_lateral_l heel_l",
    "CMU, 41 markers": "waist_front_l waist_back_r scapula_r shank_front_l metatarsal_5_head_l "
    "hand_l wrist_radial_l wrist_ulnar_l suprasternale xiphoid c7 metatarsal_2_head_l",
    "KIT": "elbow_lateral_l elbow_rear_l wrist_radial_l wrist_ulnar_l hand_radial_l hand_ulnar_l "
    "l3 asis_l psis_r",
    "Rizzoli, Qualisys": "asis_l psis_r knee_lateral_l knee_medial_l fibula_head_l "
    "tibial_tuberosity_l ankle_lateral_l ankle_medial_l heel_l metatarsal_1_head_l "
    "metatarsal_2_head_l metatarsal_5_head_l metatarsal_1_head_l metatarsal_2_head_l "
    "metatarsal_5_head_l suprasternale xiphoid c7 t8 acromion_l elbow_lateral_l wrist_radial_l "
    "wrist_ulnar_l hand_radial_l",
    "Human Body Model": "trochanter_l knee_lateral_l ankle_lateral_l elbow_lateral_l "
    "elbow_medial_l wrist_radial_l wrist_ulnar_l xiphoid vertex temple_l sacrum forehead "
    "shank_front_l",
    "OptiTrack": "asis_l knee_lateral_l knee_medial_l ankle_lateral_l metatarsal_1_head_l "
    "metatarsal_5_head_l c7 acromion_l",
    "OpenCap": "asis_r psis_l knee_lateral_l knee_medial_l ankle_lateral_l ankle_medial_l "
    "metatarsal_2_head_l metatarsal_5_head_l heel_l elbow_lateral_l wrist_radial_l "
    "knee_lateral_l c7 hip_joint_l",
    "Xsens": "asis_l sacrum knee_joint_l knee_lateral_l knee_medial_l ankle_lateral_l "
    "ankle_medial_l heel_l metatarsal_2_head_l c7 suprasternale xiphoid l5 wrist_radial_l "
    "wrist_ulnar_l elbow_rear_l vertex",
    "Cortex and others": "sacrum suprasternale wrist_radial_l wrist_ulnar_l wrist_radial_l "
    "wrist_ulnar_l waist_front_l waist_back_r",
}


@pytest.mark.parametrize("name", SETS)
def test_names_of_the_sets_of_laboratories(name):
    """Each name by itself would do for OpenSim and the like: none is left to rigidity."""
    names = SETS[name].split()
    known = landmark_names(names)
    assert {n: known[n] for n in names} == dict(zip(names, MARKS[name].split(), strict=True))


def test_joint_centres_of_video_are_no_skin_markers():
    names = [f"{side}_{j}" for side in ("left", "right") for j in ("hip", "knee", "ankle", "heel")]
    known = landmark_names(names)
    assert (known["left_knee"], known["right_hip"]) == ("knee_joint_l", "hip_joint_r")
    assert known["left_heel"] == "heel_l"


def test_no_spelling_is_of_two_landmarks():
    for table in (SPELLINGS, MIDLINE):
        words = [word for spelled in table.values() for word in spelled]
        assert len(words) == len(set(words))


@pytest.mark.parametrize(
    "name", ["RTH2", "marker12", "*110", "", "R", "L", "XYZ", "force1", "RTIA1", "C_7_x_9", "🦶"]
)
def test_unknown_names(name):
    assert landmark_of(name) is None


@pytest.mark.parametrize(
    "name", ["RKneeAngles", "LHipMoment", "RGroundReactionForce", "CentreOfMass", "LAnklePower"]
)
def test_computed_outputs_are_not_markers(name):
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


def test_spellings_resolve_names_outside_the_set():
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
def test_an_invalid_user_set_raises(tmp_path, text, message):
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


def test_a_set_with_unknown_landmarks_or_bodies_raises():
    human = person("42", "rigid")
    with pytest.raises(ParameterError, match="puts A on 'kneecap'.*ankle_lateral_r"):
        place_markers(["A"], human, MarkerSet("s", {"A": "kneecap"}, {}))
    with pytest.raises(CoordinateNotFound, match="no body 'wing_r'"):
        place_markers(["A"], human, MarkerSet("s", {}, {"A": ("wing_r", (0.0, 0.0, 0.0))}))
