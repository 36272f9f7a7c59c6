"""The textbook walk on a person: on the ground, as the book has it, recorded with honest faults."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from plantigrade.analyze import norms
from plantigrade.analyze.clinical import clinical_angles
from plantigrade.dynamics.adult_walk import adult_walk
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.textbook_recording import (
    CAMERA_NOISE_SD,
    GAP_SHARE,
    MARKERS,
    PLACEMENT_SD,
    SKIN,
    recorded,
    textbook_walk,
)
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Motion
from plantigrade.record import Record


@pytest.fixture(scope="module")
def walk():
    """Three strides of a short woman with hinged toes."""
    return textbook_walk(Human.create(1.58, 52.0, "female"), speed=1.1)


@pytest.fixture(scope="module")
def soles(walk):
    """Lowest points of the contact spheres over the walk, by side, (n_frames, n_points, 3)."""
    human = walk.human
    data = mujoco.MjData(human.model)
    geoms = {
        side: [human.model.geom(n).id for n, s, _ in human.contact_points if s == side]
        for side in "rl"
    }
    out = {side: [] for side in "rl"}
    for q in walk.qpos:
        data.qpos[:] = q
        mujoco.mj_kinematics(human.model, data)
        for side, ids in geoms.items():
            x = data.geom_xpos[ids].copy()
            x[:, 2] -= human.model.geom_size[ids, 0]
            out[side].append(x)
    return {side: np.array(x) for side, x in out.items()}


def stances(walk, side):
    """Frames of each whole stance by the book's events."""
    mine = [e for e in walk.events if e.side == side]
    for a, b in zip(mine[:-1], mine[1:], strict=True):
        if a.kind == "heel_strike":
            yield np.flatnonzero((walk.time >= a.time) & (walk.time <= b.time))


def test_it_goes_at_its_speed_and_in_steps(walk):
    seconds = walk.time[-1] - walk.time[0]
    assert (walk.qpos[-1, 0] - walk.qpos[0, 0]) / seconds == pytest.approx(1.1, rel=0.01)
    assert abs(walk.qpos[-1, 1] - walk.qpos[0, 1]) < 0.03
    kinds = [(e.side, e.kind) for e in walk.events]
    assert all(a != b for a, b in zip(kinds[:-1], kinds[1:], strict=True))
    assert len([k for k in kinds if k == ("r", "heel_strike")]) >= 3


def test_feet_stand_on_the_ground_and_do_not_slide(walk, soles):
    lowest = np.minimum(soles["r"][..., 2].min(axis=1), soles["l"][..., 2].min(axis=1))
    assert np.abs(lowest).max() < 0.012, "it floats or sinks"
    for side in "rl":
        for frames in stances(walk, side):
            flat = frames[len(frames) // 4 : len(frames) // 2]  # loading is over, the heel is down
            slid = np.ptp(soles[side][flat][..., :2].mean(axis=1), axis=0)
            assert slid.max() < 0.010, f"the {side} foot slides"


def test_joints_stay_within_their_limits(walk):
    low, high = walk.human.limits
    assert (walk.qpos[:, 7:] >= low - 1e-9).all() and (walk.qpos[:, 7:] <= high + 1e-9).all()


def test_right_and_left_walk_alike(walk):
    """Half a stride later the left leg does what the right one did."""
    right, left = (
        [e.time for e in walk.events if (e.side, e.kind) == (s, "heel_strike")] for s in "rl"
    )
    half = left[0] - right[0]
    middle = walk.time[(walk.time > 0.3) & (walk.time < walk.time[-1] - half - 0.3)]
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        right, left = (np.rad2deg(walk.qpos[:, 7 + walk.human.hinge(f"{name}_{s}")]) for s in "rl")
        a = np.interp(middle, walk.time, right)
        b = np.interp(middle + half, walk.time, left)
        assert np.abs(a - b).max() < 2.5, name


def test_adults_walk_as_adults_do_on_feet_that_do_not_slide():
    """Led by the ground as little as it takes: within the band of 42 adults."""
    walk = adult_walk(Human.create(), speed=1.24)
    human, n = walk.human, len(walk.time)
    motion = Motion(
        walk.time, walk.qpos, np.zeros((n, human.model.nv)), human.joint_names, None, walk.events
    )
    for name, rows in clinical_angles(Record(human, motion)).items():
        if name[:-2] not in norms.names(norms.ADULTS) or "progression" in name:
            continue  # without torsion of the shanks, feet point straight ahead
        band = norms.norm(name[:-2], population=norms.ADULTS)
        away = rows.mean(axis=0) - np.interp(np.arange(101), band.percent, band.mean)
        away /= np.interp(np.arange(101), band.percent, band.sd)
        assert np.abs(away).max() < 1.5 and np.sqrt(np.mean(away**2)) < 0.6, name


def test_the_recording_has_the_faults_it_says(walk):
    recording = recorded(walk, Path("walk.c3d"), seed=5)
    markers = recording.markers
    assert markers.names == tuple(MARKERS)
    assert recording.subject.height == walk.human.height and recording.subject.sex == "female"
    table = attachments(walk.human)
    places = [table[m] for m in MARKERS.values()]
    truth = PointSet(walk.human, [p.body for p in places], np.array([p.position for p in places]))
    x = truth.path(walk.qpos)
    off = markers.positions - x
    hidden = ~np.isfinite(off[..., 0])
    assert hidden.any(axis=0).sum() == int(GAP_SHARE * len(MARKERS))
    assert hidden.sum(axis=0).max() <= 0.1 * markers.rate + 1
    hard = [i for i, p in enumerate(places) if p.body[:-2] not in SKIN]
    soft = [i for i, p in enumerate(places) if p.body.startswith("femur")]
    # on bone: a steady offset and the camera's noise; on the thigh a centimetre of skin more
    placed = np.linalg.norm(np.nanmean(off[:, hard], axis=0), axis=1)
    assert 0.5 * PLACEMENT_SD < np.sqrt(np.mean(placed**2) / 3) < 1.5 * PLACEMENT_SD
    jitter = np.nanstd(np.diff(off[:, hard], axis=0)) / np.sqrt(2)
    assert CAMERA_NOISE_SD * 0.8 < jitter < CAMERA_NOISE_SD * 2
    wander = np.sqrt(np.nanvar(off[:, soft], axis=0).sum(axis=1))
    assert (wander > 0.5 * SKIN["femur"]).all() and (wander < 2 * SKIN["femur"]).all()


def test_a_seed_is_a_recording(walk):
    a, b, c = (recorded(walk, Path("w.c3d"), seed=s).markers.positions for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(np.nan_to_num(a), np.nan_to_num(c))
