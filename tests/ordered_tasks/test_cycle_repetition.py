"""A repeated cycle is a continuous walk without sliding feet."""

import numpy as np
import pytest

from plantigrade.kinematics.textbook_recording import textbook_walk
from plantigrade.models import Human
from plantigrade.models.textbook_gait import textbook_gait
from plantigrade.motion.cycles import cut_cycles
from plantigrade.ordered_tasks.cycle_repetition import find_loop, mirror, repeat_cycle

RATE = 100.0


@pytest.fixture(scope="module")
def human():
    """The person."""
    return Human.create(1.74, 71.0)


@pytest.fixture(scope="module")
def walk(human):
    """Three strides of the textbook walk, which is symmetric and periodic."""
    return textbook_walk(human, speed=1.25, rate=RATE, cycles=3)


@pytest.fixture(scope="module")
def period(human):
    """Frames of one stride."""
    d = human.dimensions
    gait = textbook_gait(1.25, d.thigh + d.shank + d.ankle_height, rate=RATE, cycles=3)
    return round((gait.heel_strikes["r"][1] - gait.heel_strikes["r"][0]) * RATE)


def turned(qpos, angle):
    """Return a motion turned about the vertical."""
    from scipy.spatial.transform import Rotation

    about = Rotation.from_rotvec([0, 0, angle])
    result = qpos.copy()
    result[:, :3] = about.apply(qpos[:, :3])
    root = about * Rotation.from_quat(np.roll(qpos[:, 3:7], -1, axis=1))
    result[:, 3:7] = np.roll(root.as_quat(), 1, axis=1)
    return result


def same_posture(a, b, tolerance):
    """Assert that two motions agree, whatever the sign of the quaternion."""
    sign = np.sign(np.sum(a[:, 3:7] * b[:, 3:7], axis=1, keepdims=True))
    np.testing.assert_allclose(a[:, 3:7], sign * b[:, 3:7], atol=tolerance)
    np.testing.assert_allclose(a[:, 7:], b[:, 7:], atol=tolerance)


@pytest.mark.parametrize("angle", [0.0, 2.0])
@pytest.mark.parametrize("extra", [1, 0], ids=["with the last frame", "without it"])
def test_a_repeated_stride_equals_the_walk_it_was_cut_from(human, walk, period, extra, angle):
    qpos = turned(walk.qpos, angle)
    start = 20
    piece = slice(start, start + period + extra)
    loop = find_loop(human, walk.time[piece], qpos[piece])
    assert loop is not None and not loop.mirrored
    time, made = repeat_cycle(human, walk.time[piece], qpos[piece], loop, times=2)
    m = min(len(time), len(qpos) - start)
    assert m > 1.5 * period
    np.testing.assert_allclose(np.diff(time), 1 / RATE, atol=2e-4)
    np.testing.assert_allclose(made[:m, :3], qpos[start : start + m, :3], atol=0.02)
    same_posture(made[:m], qpos[start : start + m], 0.06)


def test_half_a_stride_continues_with_its_mirror_image(human, walk, period):
    half = slice(0, period // 2 + 1)
    loop = find_loop(human, walk.time[half], walk.qpos[half])
    assert loop is not None and loop.mirrored
    time, made = repeat_cycle(human, walk.time[half], walk.qpos[half], loop, times=2)
    assert len(time) == len(made) == pytest.approx(2 * period, abs=4)
    np.testing.assert_allclose(made[:, 0], walk.qpos[: len(made), 0], atol=0.03)
    same_posture(made, walk.qpos[: len(made)], 0.2)  # the textbook toes land one by one


def test_joint_angles_are_continuous_at_the_seam(human, walk, period):
    piece = slice(7, 7 + period + 1)
    qpos = walk.qpos[piece].copy()
    arm = 7 + human.hinge("arm_flex_r")
    qpos[:, arm] += np.linspace(0, 0.3, len(qpos))  # a joint that does not close
    loop = find_loop(human, walk.time[piece], qpos)
    _, made = repeat_cycle(human, walk.time[piece], qpos, loop)
    within = np.abs(np.diff(qpos[:, 7:], axis=0)).max(axis=0)
    assert (np.abs(np.diff(made[:, 7:], axis=0)).max(axis=0) < 1.5 * within + 0.01).all()


def test_a_turning_walk_continues_on_its_circle(human, walk, period):
    piece = slice(0, period + 1)
    qpos = walk.qpos[piece].copy()
    bend = 0.5 * np.arange(len(qpos)) / period
    for k, angle in enumerate(bend):
        qpos[k] = turned(qpos[k : k + 1], angle)[0]
    loop = find_loop(human, walk.time[piece], qpos)
    _, made = repeat_cycle(human, walk.time[piece], qpos, loop, times=3)
    strides = (
        made[[period - 1, 2 * period - 1, 3 * period - 1], :2] - made[[0, period, 2 * period], :2]
    )
    angles = np.unwrap(np.arctan2(strides[:, 1], strides[:, 0]))
    np.testing.assert_allclose(np.diff(angles), 0.5, atol=0.02)
    np.testing.assert_allclose(
        np.linalg.norm(strides, axis=1), np.linalg.norm(strides[0]), rtol=1e-3
    )


def test_a_motion_that_does_not_close_has_no_loop(human, walk, period):
    third = slice(0, period // 3)
    assert find_loop(human, walk.time[third], walk.qpos[third]) is None
    most = slice(0, period * 3 // 4)
    assert find_loop(human, walk.time[most], walk.qpos[most]) is None
    still = np.tile(human.standing(), (100, 1))
    assert find_loop(human, np.arange(100) / RATE, still) is None
    assert find_loop(human, walk.time[:5], walk.qpos[:5]) is None


def test_mirroring_twice_returns_the_motion(human, walk):
    np.testing.assert_allclose(mirror(human, mirror(human, walk.qpos)), walk.qpos, atol=1e-12)


def test_the_mirror_image_moves_as_the_mirrored_points_do(human, walk):
    """The right ankle of the image is the left ankle mirrored in the x-z plane."""
    from plantigrade.kinematics.state import PointSet

    for qpos in walk.qpos[::40]:
        of = {
            s: PointSet(human, [f"foot_{s}", f"hand_{s}", "head"], np.zeros((3, 3)))
            for s in ("r", "l")
        }
        image = mirror(human, qpos[None])[0]
        np.testing.assert_allclose(
            of["r"].path(image[None]), of["l"].path(qpos[None]) * [1, -1, 1], atol=1e-9
        )


def test_events_of_the_repetition_make_whole_strides(data):
    from plantigrade.analyze.recorded_walk import RecordedWalk
    from plantigrade.workflows.fit import fit_trial

    for name, mirrored in (
        ("opensim/gait2392_subject01/normal_gait.mot", False),
        ("deepmimic/humanoid3d_walk.txt", False),
        ("opensim/moco_2d_walking/referenceCoordinates.sto", True),
    ):
        trial = fit_trial(data / name)[1]
        assert not cut_cycles(trial.motion.events)
        walk = RecordedWalk.of(trial).repeated(trial)
        assert len(cut_cycles(walk.motion.events)) >= 2, name
        assert any("repeated" in sentence for sentence in walk.notes)
        assert any("mirror" in sentence for sentence in walk.notes) == mirrored
