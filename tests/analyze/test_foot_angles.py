"""Foot segments: known turns are found, and the angles that the Oxford Foot Model stored."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.analyze import analyse, compare_curves
from plantigrade.analyze.foot_angles import (
    FOREFOOT,
    HINDFOOT,
    foot_angles,
    joint_angles,
    segment_axes,
    steadied,
    tibia_axes,
    unsteadiness,
)
from plantigrade.analyze.foot_segments import angles_of, feet_of, foot_segment_signals
from plantigrade.io import read
from plantigrade.kinematics.unmeasured_toes import unseen_toes_follow
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, landmarks
from plantigrade.models.skeleton import build
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

SEGMENTS = {
    "hindfoot": (*HINDFOOT, "heel_upper"),
    "forefoot": (*FOREFOOT, "metatarsal_1_head"),
    "hallux": ("hallux",),
}


@pytest.fixture(scope="module")
def human() -> Human:
    return Human.create(1.70, 65.0, joints="66")


def standing_markers(human: Human, side: str) -> dict[str, np.ndarray]:
    """The markers of one foot of a standing person, in one frame."""
    d = human.dimensions
    origins = build(d, human.sex, human.mass, human.joints, human.feet).origins
    found = {}
    for name, mark in landmarks(d).items():
        if name.endswith(f"_{side}"):
            reference = mark.reference + (
                f"_{side}" if f"{mark.reference}_{side}" in origins else ""
            )
            found[name[:-2]] = (origins[reference] + mark.position)[None]
    return found


def turned(seen: dict, segments: tuple[str, ...], axis: np.ndarray, degrees: float) -> dict:
    """The markers of some segments turned about an axis through the heel."""
    rotation = Rotation.from_rotvec(np.deg2rad(degrees) * axis).as_matrix()
    moving = {name for segment in segments for name in SEGMENTS[segment]}
    centre = seen["heel"]
    return {
        name: centre + (path - centre) @ rotation.T if name in moving else path
        for name, path in seen.items()
    }


@pytest.mark.parametrize("side", ["r", "l"])
@pytest.mark.parametrize(
    ("moving", "of", "axis", "angle"),
    [
        (("hindfoot", "forefoot", "hallux"), "tibia", 1, "hindfoot_dorsiflexion"),
        (("hindfoot",), "hindfoot", 0, "hindfoot_inversion"),
        (("forefoot", "hallux"), "hindfoot", 1, "forefoot_dorsiflexion"),
        (("forefoot", "hallux"), "forefoot", 0, "forefoot_supination"),
    ],
)
def test_a_turn_is_found_with_its_sign(human, side, moving, of, axis, angle):
    """Toes up, sole to the midline; first about the segment above, last about itself."""
    rest = standing_markers(human, side)
    tibia = np.eye(3)[None]
    about = segment_axes(rest, rest, tibia, side)[of][0, :, axis]
    signs = {"r": (1.0, -1.0), "l": (-1.0, -1.0)}[side]
    seen = turned(rest, moving, about, 12.0 * signs[axis])
    before, after = (foot_angles(m, rest, tibia, side) for m in (rest, seen))
    change = np.rad2deg(after[f"{angle}_{side}"] - before[f"{angle}_{side}"])[0]
    assert change == pytest.approx(12.0, abs=1e-6)


@pytest.mark.parametrize("side", ["r", "l"])
def test_a_toe_that_rises_is_dorsiflexed(human, side):
    rest = standing_markers(human, side)
    ahead = np.linalg.norm(rest["hallux"] - rest["metatarsal_1_head"])
    seen = rest | {"hallux": rest["hallux"] + [0.0, 0.0, 0.3 * ahead]}
    name = f"hallux_dorsiflexion_{side}"
    up, flat = (foot_angles(m, rest, np.eye(3)[None], side)[name][0] for m in (seen, rest))
    assert 10.0 < np.rad2deg(up - flat) < 25.0


def test_both_sides_are_mirror_images(human):
    rng = np.random.default_rng(4)
    mirror = np.array([1.0, -1.0, 1.0])
    rest = standing_markers(human, "r")
    seen = {n: p + 0.01 * rng.normal(size=(1, 3)) for n, p in rest.items()}
    other = [{n: p * mirror for n, p in markers.items()} for markers in (seen, rest)]
    right = foot_angles(seen, rest, np.eye(3)[None], "r")
    left = foot_angles(*other, np.eye(3)[None], "l")
    for name, angle in right.items():
        assert angle == pytest.approx(left[f"{name[:-2]}_l"], abs=1e-9), name


def test_the_whole_body_may_turn(human):
    """Angles between segments know nothing of where the person is and faces."""
    rest = standing_markers(human, "r")
    seen = turned(rest, ("forefoot",), np.array([0.6, 0.0, 0.8]), 15.0)
    turn = Rotation.from_rotvec([0.4, -0.3, 2.1]).as_matrix()
    moved = {name: path @ turn.T + [3.0, -2.0, 0.5] for name, path in seen.items()}
    a = foot_angles(seen, rest, np.eye(3)[None], "r")
    b = foot_angles(moved, rest, turn[None], "r")
    assert all(a[n] == pytest.approx(b[n], abs=1e-6) for n in a)


def test_a_hidden_marker_is_where_the_other_three_have_it(human):
    rest = standing_markers(human, "r")
    turns = Rotation.random(20, random_state=3).as_matrix()
    seen = {name: np.einsum("fij,j->fi", turns, rest[name][0]) for name in FOREFOOT}
    assert unsteadiness(seen) < 1e-9
    truth = seen["metatarsal_5_base"].copy()
    seen["metatarsal_5_base"][4:9] = np.nan
    np.testing.assert_allclose(steadied(seen, FOREFOOT)["metatarsal_5_base"], truth, atol=1e-9)
    seen["metatarsal_5_base"] = truth + [0.0, 0.0, 0.004] * (np.arange(20) % 2)[:, None]
    assert 0.0005 < unsteadiness(seen) < 0.01
    three = {name: seen[name] for name in FOREFOOT[:3]}
    assert all(steadied(three, FOREFOOT)[n] is three[n] for n in three)


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


@pytest.mark.parametrize("walk", ["HC032A03", "HC038A11"])
def test_the_stored_angles_are_found(data: Path, walk: str):
    """From the markers alone, with the hip centres that the file holds."""
    recording, static = read(data / "c3d" / f"{walk}.c3d"), read(data / "c3d" / f"{walk[:6]}01.c3d")
    stored = recording.outputs
    for side in ("r", "l"):
        seen, standing = (feet_of(r.markers, side) for r in (recording, static))
        upper = side.upper()
        knee, ankle = (
            float(np.nanmedian(np.linalg.norm(seen[mark] - stored[upper + centre], axis=1)))
            for mark, centre in (("knee_lateral", "FEO"), ("ankle_lateral", "TIO"))
        )
        tibia = tibia_axes(seen, stored[f"{upper}FEP"], knee, ankle, side)
        found = foot_angles(seen, standing, tibia, side)
        keys = {"hindfoot": "HFTBA", "forefoot": "FFHFA", "forefoot_to_tibia": "FFTBA"}
        for name, angle in found.items():
            pair, _, what = name[:-2].rpartition("_")
            pair = pair.removesuffix("_internal")
            key, column = keys.get(pair, "HXFFA"), COLUMN[what]
            theirs = stored[upper + key][:, column]
            theirs = np.where(np.abs(theirs) > 1e-9, theirs, np.nan)
            found = compare_curves(np.rad2deg(angle), theirs)
            assert found.correlation > 0.95 and found.rmse_offset_removed < 1.0, name
            assert abs(np.nanmean(np.rad2deg(angle) - theirs)) < 1.0, name


COLUMN = {
    "dorsiflexion": 0,
    "adduction": 1,
    "rotation": 1,
    "supination": 2,
    "inversion": 2,
}


def test_toes_that_are_seen_are_left_alone(human):
    q = human.standing()[None]
    for name, angle in (("mtp_angle_r", 20.0), ("mtp4_angle_r", 5.0)):
        q[0, 7 + human.hinge(name)] = np.deg2rad(angle)
    both = [Attachment(b, np.zeros(3), 0.01) for b in ("medial_phalanges_r", "lateral_phalanges_r")]
    np.testing.assert_array_equal(unseen_toes_follow(human, both, q), q)
    followed = unseen_toes_follow(human, both[:1], q)
    assert followed[0, 7 + human.hinge("mtp4_angle_r")] == pytest.approx(np.deg2rad(20.0))
    led = unseen_toes_follow(human, both[1:], q)
    assert led[0, 7 + human.hinge("mtp_angle_r")] == pytest.approx(np.deg2rad(5.0))


@pytest.mark.slow
@pytest.mark.slow
def test_a_walk_with_oxford_markers_has_foot_segments(data: Path):
    """Near the stored angles, also where no standing trial shows the markers worn in it alone."""
    recording, trial = fit_trial(data / "c3d" / "HC038A11.c3d", FitSettings())
    feet = foot_segment_signals(recording, trial)
    found = feet.figures
    assert found["foot_segments_marker_rms_mm"] < 5
    # Hindfoot dorsiflexion spans 20 to 30 degrees in normal walking.
    assert 15 < found["hindfoot_dorsiflexion_rom_r_deg"] < 35
    assert len(feet.signals["foot.names"]) == 20
    table, bare = angles_of(trial.fit, recording.static), angles_of(trial.fit)
    for side in ("r", "l"):
        theirs = recording.outputs[f"{side.upper()}HFTBA"][:, 1]
        inside = np.isin(recording.markers.time, trial.fit.time)
        ours = np.rad2deg(table[f"hindfoot_internal_rotation_{side}"])
        assert compare_curves(ours, theirs[inside]).correlation > 0.9
        for name in (f"forefoot_supination_{side}", f"hindfoot_inversion_{side}"):
            assert compare_curves(table[name], bare[name]).correlation > 0.9, name
    short = [n for n in recording.markers.names if n[1:] not in ("LCA", "STL", "CPG")]
    kept = [trial.fit.markers.index(n) for n in short if n in trial.fit.markers.names]
    fitted = replace(
        trial.fit,
        markers=trial.fit.markers.select([trial.fit.markers.names[i] for i in kept]),
        kept=trial.fit.kept[:, kept],
    )
    assert not foot_segment_signals(recording, replace(trial, fit=fitted)).signals
    # The same walk stands on the ground of its plates; three centimetres lower it does not.
    assert abs(trial.figures["sole_in_stance_mean_mm"]) < 5
    assert abs(trial.figures["sole_in_stance_worst_mm"]) < 15
    assert not any("soles" in note for note in trial.notes)
    lowered = np.array(trial.fit.qpos)
    lowered[:, 2] -= 0.03
    sunk = analyse(replace(trial.fit, qpos=lowered))
    assert sunk.figures["sole_in_stance_mean_mm"] < -25
    assert any("soles" in note for note in sunk.notes)
