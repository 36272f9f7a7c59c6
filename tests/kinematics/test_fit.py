"""Fitting markers: a person whose markers are known is found again, and lies are found out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plantigrade.analyze import compare_curves
from plantigrade.errors import FitError
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human, Person
from plantigrade.models.markers import place_markers
from plantigrade.motion import Markers, Recording, Subject

NAMES = (
    "LASI RASI LPSI RPSI C7 T10 CLAV STRN LSHO RSHO LELB RELB LWRA LWRB RWRA RWRB LFIN RFIN "
    "LFHD RFHD LBHD RBHD LTHI RTHI LKNE RKNE LKNM RKNM LTIB RTIB LANK RANK LMED RMED LHEE RHEE "
    "LTOE RTOE LD5M RD5M"
).split()
RATE = 100.0


def walker(n: int = 160, *, heading: float = 0.0, feet: str = "two-segment", lengths=None):
    """A person of own lengths in a smooth, walking-like motion: human, time, qpos."""
    human = Human.create(1.68, 62.0, "female", feet=feet, lengths=lengths)
    time = np.arange(n) / RATE
    phase = 2 * np.pi * time / 1.1
    qpos = np.tile(human.standing(), (n, 1))

    def put(name, values):
        qpos[:, 7 + human.hinge(name)] = values

    for side, shift in (("r", 0.0), ("l", np.pi)):
        put(f"hip_flexion_{side}", 0.12 + 0.40 * np.cos(phase + shift))
        put(f"hip_rotation_{side}", 0.08 * np.sin(phase + shift))
        put(f"knee_angle_{side}", 0.55 - 0.45 * np.cos(phase + shift + 0.9))
        put(f"ankle_angle_{side}", 0.25 * np.sin(2 * phase + shift))
        put(f"arm_flex_{side}", -0.3 * np.cos(phase + shift))
        put(f"elbow_flex_{side}", 0.5 + 0.1 * np.cos(phase + shift))
    put("lumbar_rotation", 0.1 * np.sin(phase))
    forward = 1.3 * time
    qpos[:, 0] = forward * np.cos(heading)
    qpos[:, 1] = forward * np.sin(heading)
    qpos[:, 2] += 0.02 * np.cos(2 * phase)
    qpos[:, 3], qpos[:, 6] = np.cos(heading / 2), np.sin(heading / 2)
    return human, time, qpos


def markers_of(human, time, qpos, *, noise=0.001, shift=0.0, seed=0, names=NAMES):
    """Markers of a motion, each put up to ``shift`` beside its landmark."""
    rng = np.random.default_rng(seed)
    placed = place_markers(names, human)
    local = np.array([placed[n].position for n in names])
    local = local + shift * rng.normal(size=local.shape)
    points = PointSet(human, [placed[n].body for n in names], local)
    x = points.path(qpos)
    return Markers(tuple(names), time, x + noise * rng.normal(size=x.shape))


def recording(markers: Markers) -> Recording:
    return Recording(Path("walk.c3d"), markers, subject=Subject(height=1.68, mass=62.0))


def test_lengths_and_angles_are_found_again():
    own = {"thigh": 0.44, "shank": 0.38, "upper_arm": 0.29}
    human, time, qpos = walker(lengths=own)
    fit = fit_markers(recording(markers_of(human, time, qpos)), Person(sex="female"))
    assert fit.metrics["marker_rms_mean_mm"] < 2.5
    for name, value in own.items():
        assert getattr(fit.human.dimensions, name) == pytest.approx(value, rel=0.03)
    assert fit.human.height == pytest.approx(1.68, abs=1e-9)
    for name in ("hip_flexion_r", "knee_angle_l", "ankle_angle_r", "elbow_flex_l"):
        i = 7 + human.hinge(name)
        assert np.rad2deg(np.abs(fit.qpos[:, i] - qpos[:, i])).mean() < 2.0, name


def test_knees_that_also_turn_do_not_tip_the_pelvis():
    """People's knees turn and give sideways; the hinge of the default body must not pass it on."""
    n = 110
    plain, time, hinged = walker(n)
    human = Human.create(1.68, 62.0, "female", joints="66", feet="two-segment")
    qpos = human.from_coordinates(*plain.to_coordinates(hinged))
    phase = 2 * np.pi * time / 1.1
    for side, shift in (("r", 0.0), ("l", np.pi)):
        turns = {"knee_rotation": (8, 0.4), "knee_adduction": (4, 1.6), "hip_adduction": (4, 0.0)}
        for name, (degrees, lead) in turns.items():
            angle = np.deg2rad(degrees) * np.sin(phase + shift + lead)
            qpos[:, 7 + human.hinge(f"{name}_{side}")] = angle
    fit = fit_markers(recording(markers_of(human, time, qpos, names=LATERAL)), Person(height=1.68))
    (here, ours), (there, truth) = (
        each.to_coordinates(q) for each, q in ((fit.human, fit.qpos), (human, qpos))
    )

    def off(name):
        found, true = ours[:, here.index(name)], truth[:, there.index(name)]
        return compare_curves(np.rad2deg(found), np.rad2deg(true)).rmse_offset_removed

    assert off("pelvis_list") < 0.5, "trusting spines no more than feet: 0.8"
    assert max(off("hip_adduction_r"), off("hip_adduction_l")) < 1.3, "so too: 1.9"


def slid(human, qpos, markers, *, slide=0.020):
    """The markers, those on lateral epicondyles slid backwards so far [m/rad] as the knee bends."""
    x = markers.positions.copy()
    thighs = np.array(
        [[s.rotations[human.body(f"femur_{k}")] for k in "rl"] for s in sweep(human, qpos)]
    )
    for k, side in enumerate("rl"):
        bent = qpos[:, 7 + human.hinge(f"knee_angle_{side}")]
        backwards = -slide * bent[:, None] * thighs[:, k, :, 0]
        x[:, markers.index(f"{side.upper()}KNE")] += backwards
    return replace(markers, positions=x)


LATERAL = tuple(n for n in NAMES if not n.endswith(("KNM", "MED")))


def test_skin_that_slides_over_the_knee_does_not_move_its_axis():
    """Seen from a thigh that its sliding marker turns, the shank turns about a lower point."""
    human, time, qpos = walker()
    markers = slid(human, qpos, markers_of(human, time, qpos, names=LATERAL))
    fit = fit_markers(recording(markers))
    for side in "rl":
        axis = fit.human.model.body_pos[fit.human.body(f"tibia_{side}")]
        place = fit.places[fit.markers.index(f"{side.upper()}KNE")].position
        above = 1e3 * (place - axis)[2]
        assert above == pytest.approx(0.015e3 * human.dimensions.thigh, abs=4), "by movement: 13"
        i = 7 + human.hinge(f"knee_angle_{side}")
        assert abs(np.rad2deg(fit.qpos[:, i] - qpos[:, i]).mean()) < 1.5


@pytest.mark.parametrize("ending", ["JC", "JC_reg", "_joint"])
def test_joint_centres_of_the_file_are_those_of_the_body(ending):
    """Skin markers of hip and knee sit low on the body; the laboratory's joint centres do not."""
    human, time, qpos = walker(lengths={"thigh": 0.45})
    markers = slid(human, qpos, markers_of(human, time, qpos, names=LATERAL), slide=0.04)
    bodies = [human.body(f"{part}_{side}") for side in "rl" for part in ("femur", "tibia", "foot")]
    joints = ("_hip", "_knee", "_ankle") if ending == "_joint" else ("_H", "_K", "_A")
    names = [f"{side}{joint}{ending}" for side in "rl" for joint in joints]
    centres = np.array([state.origins[bodies] for state in sweep(human, qpos)])
    x = np.concatenate([markers.positions, centres], axis=1)
    fit = fit_markers(recording(Markers((*markers.names, *names), time, x)))
    assert not fit.attached, "their names are known"
    there = [fit.human.body(human.body_names[b - 1]) for b in bodies]
    found = np.array([state.origins[there] for state in sweep(fit.human, fit.qpos)])
    off = 1e3 * np.linalg.norm(np.median(found - centres, axis=0), axis=1)
    assert (off < 8).all(), off


def test_of_two_hip_centres_of_a_file_the_regressed_one_is_left_out():
    """OpenCap's files hold both, nearly 2 cm apart; together they would pull the hips between."""
    human, time, qpos = walker()
    markers = markers_of(human, time, qpos)
    hips = [human.body(f"femur_{side}") for side in "rl"]
    centres = np.array([state.origins[hips] for state in sweep(human, qpos)])
    names = (*markers.names, "R_HJC", "L_HJC", "R_HJC_reg", "L_HJC_reg")
    x = np.concatenate([markers.positions, centres, centres + [0.0, 0.0, 0.017]], axis=1)
    left_out = "R_HJC_reg (a regression's estimate of what R_HJC gives without one)"
    fit = fit_markers(recording(Markers(names, time, x)))
    assert any(left_out in note for note in fit.warnings)
    alone = fit_markers(
        recording(Markers(names[:-4] + names[-2:], time, np.delete(x, [-4, -3], 1)))
    )
    assert not any("R_HJC_reg" in note for note in alone.warnings), "without another one it is used"


def test_marker_places_off_their_landmarks_are_found():
    human, time, qpos = walker()
    fit = fit_markers(recording(markers_of(human, time, qpos, shift=0.012)))
    assert fit.metrics["marker_rms_mean_mm"] < 3.0


def test_joint_limits_are_never_left():
    human, time, qpos = walker()
    fit = fit_markers(recording(markers_of(human, time, qpos, noise=0.02)))
    low, high = fit.human.limits
    assert (fit.qpos[:, 7:] >= low).all() and (fit.qpos[:, 7:] <= high).all()


@pytest.mark.parametrize("degrees", [90, 180, -90])
def test_the_person_is_turned_to_face_x(degrees):
    human, time, qpos = walker(heading=np.deg2rad(degrees))
    fit = fit_markers(recording(markers_of(human, time, qpos)))
    assert np.rad2deg(fit.heading) % 360 == pytest.approx(-degrees % 360)
    moved = fit.qpos[-1, :2] - fit.qpos[0, :2]
    assert moved[0] == pytest.approx(1.3 * time[-1], rel=0.02) and abs(moved[1]) < 0.05


def test_gaps_are_bridged():
    human, time, qpos = walker()
    markers = markers_of(human, time, qpos)
    x = markers.positions.copy()
    rng = np.random.default_rng(1)
    for column in rng.choice(len(NAMES), 8, replace=False):
        start = rng.integers(20, 100)
        x[start : start + 25, column] = np.nan
    fit = fit_markers(recording(Markers(markers.names, time, x)))
    assert len(fit.time) == len(time)
    assert fit.metrics["marker_rms_mean_mm"] < 2.5


def test_swapped_markers_are_put_back_and_named():
    human, time, qpos = walker()
    markers = markers_of(human, time, qpos)
    x = markers.positions.copy()
    a, b = NAMES.index("LKNE"), NAMES.index("LTHI")
    x[60:75, [a, b]] = x[60:75, [b, a]]
    fit = fit_markers(recording(Markers(markers.names, time, x)))
    assert any("LKNE" in w and "LTHI" in w and "swapped" in w for w in fit.warnings)
    assert fit.metrics["marker_rms_worst_frame_mm"] < 6


def test_flying_samples_are_left_out_and_named():
    human, time, qpos = walker()
    markers = markers_of(human, time, qpos)
    x = markers.positions.copy()
    column = NAMES.index("RANK")
    x[80:90, column] += [0.3, 0.2, 0.4]
    fit = fit_markers(recording(Markers(markers.names, time, x)))
    assert any("RANK in 10 frames" in w for w in fit.warnings)
    i = 7 + human.hinge("knee_angle_r")
    assert np.rad2deg(np.abs(fit.qpos[78:92, i] - qpos[78:92, i])).max() < 8


def test_markers_of_unknown_name_go_to_the_segment_they_move_with():
    human, time, qpos = walker()
    known = markers_of(human, time, qpos)
    cluster = PointSet(
        human, ["femur_r"] * 3 + ["tibia_l"], np.array([[0.1, -0.08, -0.2], [0.1, -0.05, -0.3],
                                                        [0.02, -0.1, -0.25], [0.05, 0.06, -0.2]])
    )  # fmt: skip
    extra = cluster.path(qpos)
    names = (*known.names, "X1", "X2", "X3", "X4")
    fit = fit_markers(
        recording(Markers(names, time, np.concatenate([known.positions, extra], axis=1)))
    )
    assert {k: fit.attached[k] for k in ("X1", "X2", "X3", "X4")} == {
        "X1": "femur_r", "X2": "femur_r", "X3": "femur_r", "X4": "tibia_l",
    }  # fmt: skip


def test_stature_is_estimated_if_it_is_not_given():
    human, time, qpos = walker()
    bare = Recording(Path("walk.trc"), markers_of(human, time, qpos))
    fit = fit_markers(bare, Person(sex="female"))
    assert fit.human.height == pytest.approx(1.68, abs=0.06)
    assert any("stature" in w for w in fit.warnings)


@pytest.mark.parametrize(("share", "stature"), [(0.499, 1.58), (0.533, 1.74)])
def test_legs_alone_give_the_stature_of_people_with_such_legs(share, stature):
    """Short legs belong to short people only in part: by proportion the first would be 1.49 m."""
    leg = share * stature
    own = {"thigh": 0.47 * leg, "shank": 0.455 * leg, "ankle_height": 0.075 * leg}
    human, time, qpos = walker(lengths=own)
    legs = tuple(n for n in NAMES if n[1:] in "ASI PSI THI KNE KNM TIB ANK MED HEE TOE D5M".split())
    fit = fit_markers(Recording(Path("walk.trc"), markers_of(human, time, qpos, names=legs)))
    assert fit.human.height == pytest.approx(stature, abs=0.05)
    assert fit.metrics["height_estimated"]
    said = next(note for note in fit.warnings if "stature" in note)
    assert "± 0.04 m (standard error)" in said and "--height" in said


def test_unknown_names_alone_say_what_to_do():
    human, time, qpos = walker(n=20)
    markers = markers_of(human, time, qpos)
    odd = Markers(tuple(f"Q{i}" for i in range(len(NAMES))), time, markers.positions)
    with pytest.raises(FitError, match="marker-set"):
        fit_markers(recording(odd))


def test_nothing_seen_is_an_error():
    x = np.full((30, len(NAMES), 3), np.nan)
    with pytest.raises(FitError):
        fit_markers(recording(Markers(tuple(NAMES), np.arange(30) / RATE, x)))
