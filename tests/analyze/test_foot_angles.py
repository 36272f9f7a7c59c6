"""Foot segments: known turns are found, with the signs and the order of the Oxford Foot Model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.analyze.foot_angles import (
    closest_rotation,
    foot_angles,
    joint_angles,
    segment_rotations,
)
from plantigrade.analyze.foot_segments import foot_segment_signals
from plantigrade.analyze.statistics import rmse_offset_removed
from plantigrade.errors import ParameterError
from plantigrade.io import read
from plantigrade.kinematics.fit import fit_markers, unseen_toes_follow
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human, Person
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import place_markers
from plantigrade.motion import Markers, Recording, Subject
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

OXFORD = (
    "LASI RASI SACR C7 T10 CLAV STRN LSHO RSHO LELB RELB LWRA LWRB RWRA RWRB LFHD RFHD LBHD RBHD "
    "LTHI RTHI LKNE RKNE LHFB RHFB LTUB RTUB LTIB RTIB LSHN RSHN LANK RANK LHEE RHEE LCPG RCPG "
    "LLCA RLCA LSTL RSTL LNAV RNAV LP1M RP1M LP5M RP5M LD5M RD5M LTOE RTOE LHLX RHLX"
).split()


@pytest.fixture(scope="module")
def human() -> Human:
    return Human.create(1.70, 65.0, joints="66")


def posed(human: Human, **degrees: float) -> np.ndarray:
    """Standing with some coordinates turned, one frame."""
    q = human.standing()
    for name, angle in degrees.items():
        q[7 + human.hinge(name)] = np.deg2rad(angle)
    return q[None]


def angles_of(human: Human, qpos: np.ndarray) -> dict[str, np.ndarray]:
    table = foot_angles(human, np.arange(len(qpos)) / 100.0, qpos)
    return {n: np.rad2deg(table[n]) for n in table.names}


def test_standing_is_zero(human):
    for name, angle in angles_of(human, human.standing()[None]).items():
        assert angle == pytest.approx(0.0, abs=1e-9), name


@pytest.mark.parametrize("side", ["r", "l"])
@pytest.mark.parametrize(
    ("hinge", "angle"),
    [
        ("heel_angle", "dorsiflexion"),
        ("heel_inversion", "inversion"),
        ("heel_adduction", "internal_rotation"),
    ],
)
def test_a_heel_turned_alone(human, side, hinge, angle):
    """The hindfoot turns against the tibia; the forefoot, left behind, the other way."""
    found = angles_of(human, posed(human, **{f"{hinge}_{side}": 12.0}))
    opposite = {"inversion": "supination", "internal_rotation": "adduction"}.get(angle, angle)
    for name, value in found.items():
        expected = {f"hindfoot_{angle}_{side}": 12.0, f"forefoot_{opposite}_{side}": -12.0}
        assert value == pytest.approx(expected.get(name, 0.0), abs=1e-9), name


@pytest.mark.parametrize("side", ["r", "l"])
def test_signs_are_what_their_names_say(human, side):
    """Seen in the world: toes up, sole to the midline, toes to the midline."""
    medial = 1.0 if side == "r" else -1.0  # the midline lies left of the right foot
    up = segment_rotations(human, posed(human, **{f"mtp_angle_{side}": 20.0}))[side]
    assert (up["hallux"][0] @ [1, 0, 0])[2] > 0.3
    q = posed(human, **{f"mtp_angle_{side}": 20.0})
    assert angles_of(human, q)[f"hallux_dorsiflexion_{side}"] == pytest.approx(20.0)
    q = posed(human, **{f"heel_inversion_{side}": 20.0})
    sole = segment_rotations(human, q)[side]["hindfoot"][0] @ [0, 0, -1]
    assert medial * sole[1] > 0.3 and angles_of(human, q)[f"hindfoot_inversion_{side}"] > 0
    q = posed(human, **{f"ankle_rotation_{side}": 20.0})
    toes = segment_rotations(human, q)[side]["forefoot"][0] @ [1, 0, 0]
    assert medial * toes[1] > 0.3 and angles_of(human, q)[f"forefoot_to_tibia_adduction_{side}"] > 0


def test_both_sides_are_mirror_images(human):
    rng = np.random.default_rng(4)
    names = ("ankle_angle", "subtalar_angle", "ankle_rotation", "heel_angle", "heel_inversion")
    names += ("heel_adduction", "cuboid_angle", "cuboid_inversion", "mtp_angle", "knee_rotation")
    turned = {n: rng.uniform(-15, 15) for n in names}
    q = posed(human, **{f"{n}_{s}": a for n, a in turned.items() for s in ("r", "l")})
    found = angles_of(human, q)
    for name in found:
        if name.endswith("_r"):
            assert found[name] == pytest.approx(found[f"{name[:-2]}_l"], abs=1e-9), name


def test_the_whole_body_may_turn(human):
    """Angles between segments know nothing of where the person is and faces."""
    q = posed(human, heel_inversion_r=9.0, ankle_angle_l=-14.0, cuboid_inversion_r=8.0)
    other = q.copy()
    other[0, :3] += [3.0, -2.0, 0.5]
    turn = Rotation.from_rotvec([0.4, -0.3, 2.1])
    own = Rotation.from_quat(np.roll(q[0, 3:7], -1))
    other[0, 3:7] = np.roll((turn * own).as_quat(), 1)
    a, b = angles_of(human, q), angles_of(human, other)
    assert all(a[n] == pytest.approx(b[n], abs=1e-6) for n in a)


def test_the_forefoot_lies_between_its_two_bodies(human):
    found = angles_of(human, posed(human, cuboid_inversion_r=20.0))
    assert 1.0 < found["forefoot_supination_r"] < 19.0
    assert found["forefoot_supination_l"] == pytest.approx(0.0, abs=1e-9)


def test_the_closest_rotation_is_the_one_that_was_made():
    rng = np.random.default_rng(2)
    rest = rng.normal(size=(6, 3))
    turned = Rotation.random(20, random_state=3).as_matrix()
    moved = np.einsum("fij,pj->fpi", turned, rest) + rng.normal(size=(20, 1, 3))
    np.testing.assert_allclose(closest_rotation(rest, moved), turned, atol=1e-12)
    flat = rest * [1, 1, 0]  # points of a plane: never a reflection
    moved = np.einsum("fij,pj->fpi", turned, flat)
    np.testing.assert_allclose(closest_rotation(flat, moved), turned, atol=1e-9)


def test_other_feet_are_refused():
    with pytest.raises(ParameterError, match="multi-segment"):
        segment_rotations(Human.create(feet="rigid"), Human.create(feet="rigid").standing()[None])


def test_order_and_signs_give_the_stored_angles(data: Path):
    """The model that wrote the file stored its axes too: its angles follow from them."""
    outputs = read(data / "c3d" / "HC038A11.c3d").outputs
    for side in ("r", "l"):

        def axes(segment: str, side: str = side) -> np.ndarray:
            """Forward, left and up, 50 mm from the origin of a segment."""
            prefix = side.upper() + segment
            ends = [outputs[f"{prefix}{k}"] - outputs[f"{prefix}0"] for k in (3, 2, 1)]
            return np.stack([e / np.linalg.norm(e, axis=1)[:, None] for e in ends], axis=2)

        for above, below, stored in (("HDF", "FOF", "FFHFA"), ("FOF", "HLX", "HXFFA")):
            found = np.rad2deg(joint_angles(axes(above), axes(below), side))
            np.testing.assert_allclose(found, outputs[side.upper() + stored], atol=0.01)


def stepping(human: Human, n: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """A walking-like motion in which every segment of the feet moves."""
    time = np.arange(n) / 100.0
    phase = 2 * np.pi * time / 1.1
    qpos = np.tile(human.standing(), (n, 1))
    qpos[:, 0] += 1.2 * time

    def put(name, degrees):
        qpos[:, 7 + human.hinge(name)] = np.deg2rad(degrees)

    for side, shift in (("r", 0.0), ("l", np.pi)):
        put(f"hip_flexion_{side}", 8 + 22 * np.cos(phase + shift))
        put(f"knee_angle_{side}", 32 - 26 * np.cos(phase + shift + 0.9))
        put(f"ankle_angle_{side}", 12 * np.sin(2 * phase + shift))
        put(f"subtalar_angle_{side}", 6 * np.sin(phase + shift + 0.5))
        put(f"ankle_rotation_{side}", 5 * np.cos(phase + shift + 1.0))
        put(f"heel_angle_{side}", 6 * np.sin(phase + shift + 2.0))
        put(f"heel_inversion_{side}", 7 * np.cos(phase + shift))
        put(f"heel_adduction_{side}", 5 * np.sin(2 * phase + shift))
        put(f"cuboid_inversion_{side}", 5 * np.cos(phase + shift + 2.5))
        put(f"mtp_angle_{side}", 15 + 15 * np.cos(phase + shift + 1.5))
    return time, qpos


def test_segments_are_found_again_from_oxford_markers(human):
    time, qpos = stepping(human)
    placed = place_markers(OXFORD, human)
    rng = np.random.default_rng(5)
    local = np.array([placed[n].position for n in OXFORD])
    local = local + 0.005 * rng.normal(size=local.shape)
    points = PointSet(human, [placed[n].body for n in OXFORD], local)
    x = points.path(qpos)
    markers = Markers(tuple(OXFORD), time, x + 0.0005 * rng.normal(size=x.shape))
    recording = Recording(Path("walk.c3d"), markers, subject=Subject(height=1.70, mass=65.0))
    fitted = fit_markers(recording, Person(joints="66"))
    assert fitted.metrics["marker_rms_mean_mm"] < 2.5
    truth, found = angles_of(human, qpos), angles_of(fitted.human, fitted.qpos)
    for name, angle in truth.items():
        assert rmse_offset_removed(found[name], angle) < 2.5, name
    low, high = fitted.human.limits
    assert (fitted.qpos[:, 7:] >= low).all() and (fitted.qpos[:, 7:] <= high).all()
    for side in ("r", "l"):  # no marker on the lateral toes: they bend with the medial ones
        toes = [fitted.qpos[:, 7 + human.hinge(f"{j}_angle_{side}")] for j in ("mtp", "mtp4")]
        np.testing.assert_array_equal(*toes)


def test_toes_that_are_seen_are_left_alone(human):
    q = posed(human, mtp_angle_r=20.0, mtp4_angle_r=5.0)
    both = [Attachment(b, np.zeros(3), 0.01) for b in ("medial_phalanges_r", "lateral_phalanges_r")]
    np.testing.assert_array_equal(unseen_toes_follow(human, both, q), q)
    followed = unseen_toes_follow(human, both[:1], q)
    assert followed[0, 7 + human.hinge("mtp4_angle_r")] == pytest.approx(np.deg2rad(20.0))
    led = unseen_toes_follow(human, both[1:], q)
    assert led[0, 7 + human.hinge("mtp_angle_r")] == pytest.approx(np.deg2rad(5.0))


@pytest.mark.slow
def test_a_walk_with_oxford_markers_has_foot_segments(data: Path):
    """Fitted with the default feet; the segments come besides, near the stored angles."""
    settings = FitSettings()
    recording, trial = fit_trial(data / "c3d" / "HC038A11.c3d", settings)
    feet = foot_segment_signals(recording, trial, settings.known)
    assert trial.fit.human.feet == "two-segment"
    found = feet.figures
    assert found["foot_segments_marker_rms_mm"] < 5
    # Hindfoot dorsiflexion spans 20 to 30 degrees in normal walking.
    assert 15 < found["hindfoot_dorsiflexion_rom_r_deg"] < 35
    assert len(feet.signals["foot.names"]) >= 10
    bare = [n for n in recording.markers.names if n[1:] not in ("LCA", "STL", "CPG")]
    few = replace(trial, fit=replace(trial.fit, markers=trial.fit.markers.select(bare)))
    assert not foot_segment_signals(recording, few, settings.known).signals
