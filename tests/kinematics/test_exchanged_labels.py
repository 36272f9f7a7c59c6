"""Labels exchanged through a whole recording are found and put back; right ones are left alone."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade import io
from plantigrade.errors import FitError
from plantigrade.kinematics.exchanged_labels import Exchange, Landmarks, exchanged_by_anatomy
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.sides import mirror_axis, swap_sides
from plantigrade.kinematics.standing_trial import exchanged_by_standing, require_same_person
from plantigrade.models import Human
from plantigrade.models.markers import landmark_names, other_side, place_markers
from plantigrade.motion import Markers, Recording
from plantigrade.spatial.conventions import rotation_matrix
from tests.kinematics.test_fit import NAMES, markers_of, recording, walker

RECORDINGS = (
    "c3d/HC032A01.c3d",
    "c3d/HC032A03.c3d",
    "c3d/HC038A11.c3d",
    "c3d/HC038A27.c3d",
    "c3d/gaitalytics_treadmill_events.c3d",
    "c3d/opensim_walking2.c3d",
    "opensim/gait2392_subject01/subject01_static.trc",
    "opensim/gait2392_subject01/subject01_walk1.trc",
    "opensim/opencap_subject4/DJ1.trc",
    "opensim/opencap_subject4/STS1.trc",
    "opensim/opencap_subject4/squats1.trc",
    "opensim/rajagopal_walk/markers_walk.trc",
    "opensim/running_subject04/run300.trc",
)
STANDING = {
    "c3d/HC032A03.c3d": "c3d/HC032A01.c3d",
    "c3d/HC038A27.c3d": "c3d/HC038A01.c3d",
    "opensim/gait2392_subject01/subject01_walk1.trc": (
        "opensim/gait2392_subject01/subject01_static.trc"
    ),
    "opensim/opencap_subject4/DJ1.trc": "opensim/opencap_subject4/static1.trc",
    "opensim/opencap_subject4/STS1.trc": "opensim/opencap_subject4/static1.trc",
}


@cache
def read(path: Path) -> Recording:
    """Read a recording once."""
    return io.read(path)


@pytest.fixture(scope="module")
def human() -> Human:
    """A person of usual size."""
    return Human.create(1.72, 70.0, "male")


def exchanged(markers: Markers, *pairs: tuple[str, str]) -> Markers:
    """Return the markers with the labels of pairs exchanged."""
    order = list(range(len(markers.names)))
    for a, b in pairs:
        i, j = markers.index(a), markers.index(b)
        order[i], order[j] = order[j], order[i]
    return replace(markers, positions=markers.positions[:, order])


def known(human: Human, markers: Markers) -> Landmarks:
    """Return the markers of known place that are ever seen."""
    placed = place_markers(markers.names, human)
    seen = np.isfinite(markers.positions[..., 0]).any(axis=0)
    pairs = zip(markers.names, seen, strict=True)
    found = {n: p for n, ever in pairs if ever and (p := placed[n]) is not None}
    return Landmarks(human, tuple(found), tuple(found.values()))


def found(human: Human, markers: Markers) -> Exchange:
    """Return what anatomy and rigidity say of markers."""
    own = known(human, markers)
    return exchanged_by_anatomy(own, markers.select(own.names).positions, "walk.c3d")


@pytest.mark.parametrize("name", RECORDINGS)
def test_labels_that_are_right_are_left_alone(data, human, name):
    assert not found(human, read(data / name).markers)


@pytest.mark.parametrize("name", ["c3d/HC038A27.c3d", "opensim/opencap_subject4/squats1.trc"])
@pytest.mark.parametrize("angle", [-90, 45, 90, 180])
def test_a_lying_or_leaning_person_is_unchanged(data, human, name, angle):
    """On the back, the face or the head, or bent: no label is exchanged, nobody is mirrored."""
    markers = read(data / name).markers
    turn = Rotation.from_euler("y", angle, degrees=True).as_matrix()
    assert not found(human, replace(markers, positions=markers.positions @ turn.T))


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("c3d/HC032A03.c3d", "LFHD-LBHD RFHD-RBHD"),  # front and back of the head
        ("c3d/HC038A11.c3d", "LFHD-RBHD RFHD-LBHD"),  # turned round
        ("c3d/HC032A01.c3d", "LFHD-RFHD LBHD-RBHD"),
        ("c3d/opensim_walking2.c3d", "LFHD-LBHD"),
        ("c3d/HC032A01.c3d", "LASI-RASI"),
        ("c3d/HC038A11.c3d", "LASI-RASI LANK-RANK"),
        ("c3d/opensim_walking2.c3d", "LASI-RASI LPSI-RPSI"),
        ("c3d/opensim_walking2.c3d", "LMFC-RMFC"),  # 2 cm from each other in passing
        ("c3d/opensim_walking2.c3d", "LMFC-LLFC"),
        ("c3d/HC038A11.c3d", "LKNE-RKNE"),
        ("c3d/HC038A27.c3d", "LHEE-LTOE"),
        ("c3d/HC032A03.c3d", "LELB-RELB LWRA-RWRA LWRB-RWRB"),
        ("c3d/gaitalytics_treadmill_events.c3d", "LHEE-RHEE LMT2-RMT2 LMT5-RMT5"),  # the feet
        ("opensim/opencap_subject4/DJ1.trc", "r_knee-L_knee"),
        ("opensim/opencap_subject4/squats1.trc", "r.ASIS-r.PSIS L.ASIS-L.PSIS"),
        ("opensim/rajagopal_walk/markers_walk.trc", "R.Shoulder-L.Shoulder"),
        ("opensim/running_subject04/run300.trc", "LTOE-RTOE"),
    ],
)
def test_exchanged_labels_are_put_back(data, human, name, pairs):
    markers = read(data / name).markers
    wrong = exchanged(markers, *(tuple(pair.split("-")) for pair in pairs.split()))
    back = found(human, wrong)
    np.testing.assert_array_equal(back.undone(wrong).positions, markers.positions)
    cycles = {frozenset(cycle) for cycle in back.cycles}
    assert cycles == {frozenset(pair.split("-")) for pair in pairs.split()}


@pytest.mark.parametrize("name", ["c3d/HC038A11.c3d", "c3d/opensim_walking2.c3d"])
def test_both_legs_are_exchanged(data, human, name):
    markers = read(data / name).markers
    places = dict(zip(*(lambda k: (k.names, k.places))(known(human, markers)), strict=True))
    limbs = ("femur", "tibia", "foot", "toes")
    legs = [n for n, p in places.items() if p.body.startswith(limbs)]
    pairs = {tuple(sorted((n, twin))) for n in legs if (twin := other_side(n, legs))}
    wrong = exchanged(markers, *pairs)
    np.testing.assert_array_equal(found(human, wrong).undone(wrong).positions, markers.positions)


@pytest.mark.parametrize("name", ["c3d/HC032A03.c3d", "c3d/gaitalytics_treadmill_events.c3d"])
@pytest.mark.parametrize("mirror", [swap_sides, mirror_axis])
def test_a_mirrored_person_is_refused_and_mended(data, human, name, mirror):
    """Names or an axis exchanged is one and the same to the eye; either option mends its own."""
    whole = read(data / name)
    wrong = mirror(replace(whole, outputs={}))
    with pytest.raises(FitError, match="--swap-sides.*--mirror-axis"):
        found(human, wrong.markers)
    mended = mirror(wrong)
    assert not found(human, mended.markers)
    assert mended.events == whole.events
    for again, plate in zip(mended.plates, whole.plates, strict=True):
        np.testing.assert_array_equal(again.force, plate.force)


LEGS = "asis thigh knee_lateral shank ankle_lateral heel metatarsal_2_head toe_tip hallux".split()
SACRUM, MEDIAL = ["psis", "sacrum"], ["knee_medial", "ankle_medial", "metatarsal_5_head"]
TRUNK = "c7 t10 suprasternale xiphoid scapula acromion".split()


def only(markers: Markers, marks: list[str]) -> Markers:
    """Return the markers on these landmarks, whose side is left out."""
    named = landmark_names(markers.names)
    kept = [n for n, mark in named.items() if mark and re.sub("_[rl]$", "", mark) in marks]
    return markers.select(kept)


@pytest.mark.parametrize(
    ("name", "marks"),
    [
        ("c3d/HC038A11.c3d", LEGS),  # a walk; the anterior iliac spines and the legs alone
        ("c3d/HC038A11.c3d", LEGS + SACRUM),
        ("c3d/HC032A03.c3d", LEGS + TRUNK),  # Plug-in Gait without sacrum
        ("c3d/HC038A27.c3d", LEGS + TRUNK + SACRUM),  # a turn
        ("c3d/HC032A01.c3d", LEGS),  # people who stand
        ("opensim/gait2392_subject01/subject01_static.trc", LEGS + MEDIAL),
        ("c3d/gaitalytics_treadmill_events.c3d", LEGS + MEDIAL),
        ("c3d/opensim_walking2.c3d", LEGS),
        ("opensim/rajagopal_walk/markers_walk.trc", LEGS + SACRUM),
        ("opensim/opencap_subject4/STS1.trc", LEGS + TRUNK),  # up from a chair
        ("opensim/opencap_subject4/squats1.trc", LEGS + MEDIAL),
        ("opensim/opencap_subject4/DJ1.trc", LEGS),
        ("opensim/running_subject04/run300.trc", LEGS),
    ],
)
def test_a_mirrored_person_of_few_markers_is_refused(data, human, name, marks):
    """No pose puts left and right where they are and the toes in front; the option mends it."""
    whole = read(data / name)
    whole = replace(whole, markers=only(whole.markers, marks), outputs={}, static=None)
    assert not found(human, whole.markers)
    wrong = swap_sides(whole)
    with pytest.raises(FitError, match="--swap-sides.*--mirror-axis"):
        found(human, wrong.markers)
    mended = swap_sides(wrong).markers
    assert mended.names == whole.markers.names
    np.testing.assert_array_equal(mended.positions, whole.markers.positions)


@pytest.mark.parametrize("name", ["c3d/HC038A27.c3d", "opensim/opencap_subject4/squats1.trc"])
@pytest.mark.parametrize("angle", [-90, 45, 90, 180])
def test_a_mirrored_person_who_lies_is_refused(data, human, name, angle):
    markers = read(data / name).markers
    turn = Rotation.from_euler("y", angle, degrees=True).as_matrix()
    with pytest.raises(FitError, match="mirrored"):
        found(human, replace(markers, positions=markers.positions * [1, -1, 1] @ turn.T))


def test_the_recording_that_is_mirrored_is_named(data):
    """The standing trial alone may be: it is named, not the recording."""
    walk, still = (read(data / f"c3d/HC032A0{i}.c3d") for i in (3, 1))
    marks = LEGS + TRUNK + SACRUM
    walk, still = (replace(r, markers=only(r.markers, marks), outputs={}) for r in (walk, still))
    with pytest.raises(FitError, match=r"HC032A01\.c3d: the person is mirrored"):
        fit_markers(walk, static=mirror_axis(still))


def test_a_person_who_walks_backwards_is_fitted(data):
    """A walk played in reverse is no mirror image: the same poses, the same error."""
    walk = read(data / "c3d/HC032A03.c3d")
    ahead = replace(walk, markers=only(walk.markers, LEGS), plates=(), events=(), outputs={})
    back = replace(ahead, markers=replace(ahead.markers, positions=ahead.markers.positions[::-1]))
    one, other = (fit_markers(r) for r in (ahead, back))
    speeds = [forward_speed(fit) for fit in (one, other)]
    assert speeds[0] > 1 and speeds[1] < -1
    errors = [fit.metrics["marker_rms_mean_mm"] for fit in (one, other)]
    assert abs(errors[1] - errors[0]) < 0.5 and max(errors) < 6


def forward_speed(fit) -> float:
    """Return the mean speed of the pelvis to where it faces [m/s]."""
    faces = rotation_matrix(fit.qpos[:, 3:7])[:, :2, 0].mean(axis=0)
    way = fit.qpos[-1, :2] - fit.qpos[0, :2]
    return float(way @ faces / np.linalg.norm(faces) / (fit.time[-1] - fit.time[0]))


def test_events_and_unknown_names_change_sides(data):
    walk = read(data / "c3d/opensim_walking2.c3d")
    swapped = swap_sides(walk)
    assert swapped.markers.names.index("LTH1") == walk.markers.names.index("RTH1")
    turned = read(data / "c3d/HC038A11.c3d")
    assert [e.side for e in swap_sides(turned).events] != [e.side for e in turned.events]
    named = replace(turned, plates=tuple(replace(p, side="r") for p in turned.plates))
    assert {p.side for p in swap_sides(named).plates} == {None}


@pytest.mark.parametrize(("name", "standing"), STANDING.items())
def test_a_standing_trial_of_the_person_finds_no_fault(data, human, name, standing):
    trial, still = read(data / name).markers, read(data / standing).markers
    own = known(human, trial)
    assert not exchanged_by_standing(trial, still, own.names)
    require_same_person(trial, still, segments(own), standing)


def segments(own: Landmarks) -> dict[str, str]:
    return {n: p.body for n, p in zip(own.names, own.places, strict=True)}


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("opensim/opencap_subject4/DJ1.trc", "r_thigh1-r_thigh3"),  # within a cluster
        ("opensim/opencap_subject4/DJ1.trc", "r_thigh1-L_thigh1 r_thigh2-L_thigh2 "
         "r_thigh3-L_thigh3 r_thigh4-L_thigh4"),
        ("opensim/opencap_subject4/STS1.trc", "r_sh2-r_sh3"),
        ("c3d/HC038A27.c3d", "LTHI-LKNE"),
        ("c3d/HC032A03.c3d", "LNAV-LP1M"),
        ("opensim/gait2392_subject01/subject01_walk1.trc", "R.Shank.Upper-R.Shank.Front"),
    ],
)  # fmt: skip
def test_a_standing_trial_finds_exchanged_labels(data, human, name, pairs):
    markers = read(data / name).markers
    wrong = exchanged(markers, *(tuple(pair.split("-")) for pair in pairs.split()))
    still = read(data / STANDING[name]).markers
    back = exchanged_by_standing(wrong, still, known(human, markers).names)
    np.testing.assert_array_equal(back.undone(wrong).positions, markers.positions)


@pytest.mark.parametrize("name", ["c3d/HC038A11.c3d", "c3d/HC038A27.c3d"])
def test_a_standing_trial_of_another_person_is_refused(data, human, name):
    trial, other = read(data / name).markers, read(data / "c3d/HC032A01.c3d").markers
    with pytest.raises(FitError, match="another person"):
        require_same_person(trial, other, segments(known(human, trial)), "HC032A01.c3d")


@pytest.mark.parametrize("seed", range(3))
def test_a_standing_trial_whose_markers_moved_a_little_is_taken(data, human, seed):
    """Every marker moved by 4 mm, one in five by 2 cm."""
    trial = read(data / "c3d/HC038A11.c3d").markers
    still = read(data / "c3d/HC038A01.c3d").markers
    rng = np.random.default_rng(seed)
    moved = rng.normal(scale=0.004 / np.sqrt(3), size=(len(still.names), 3))
    moved[rng.random(len(moved)) < 0.2] += 0.012
    still = replace(still, positions=still.positions + moved)
    require_same_person(trial, still, segments(known(human, trial)), "HC038A01.c3d")


def test_a_fit_with_the_head_turned_round():
    """The head faces ahead, and the run says what was done."""
    person, time, qpos = walker(60)
    whole = markers_of(person, time, qpos)
    wrong = exchanged(whole, ("LFHD", "LBHD"), ("RFHD", "RBHD"))
    fit = fit_markers(recording(wrong))
    assert fit.metrics["labels_exchanged"] == [["LBHD", "LFHD"], ["RBHD", "RFHD"]]
    assert any("LBHD and LFHD; RBHD and RFHD" in w for w in fit.warnings)
    assert fit.metrics["marker_rms_mean_mm"] < 2.5
    assert fit.recording.markers.names == whole.names
    turned = [i for i, c in enumerate(fit.human.coordinates) if c.startswith("neck_")]
    assert np.rad2deg(np.abs(fit.qpos[:, 7:][:, turned])).max() < 15


def test_markers_of_unknown_name_on_trunk_and_shoulders_stay_there():
    """Sternal notch, back and shoulders keep their distances to the trunk, not to the head."""
    person, time, qpos = walker(60)
    nod = 0.3 * np.sin(2 * np.pi * time / 0.9)
    for joint in ("neck_extension", "neck_rotation"):
        if joint in person.coordinates:
            qpos[:, 7 + person.hinge(joint)] = nod
    whole = markers_of(person, time, qpos)
    new = {"CLAV": "X1", "LSHO": "X2", "RSHO": "X3", "LASI": "X4"}
    names = tuple(new.get(n, n) for n in NAMES)
    fit = fit_markers(Recording(recording(whole).source, replace(whole, names=names)))
    placed = place_markers(NAMES, person)
    assert fit.attached == {x: placed[n].body for n, x in new.items()}
