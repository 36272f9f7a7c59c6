import ezc3d
import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.motion import ForcePlate
from plantigrade.motion.events import (
    contact_events,
    detect_gait_events,
    ground_velocity,
    plate_events,
)
from tests.motion.walkers import compare, walker

WALKS = {
    "usual": {},
    "slow": {"speed": 0.5, "stride_time": 1.7, "stance": 0.68},
    "fast": {"speed": 2.2, "stride_time": 0.85, "stance": 0.56},
    "runner": {"speed": 3.5, "stride_time": 0.7, "stance": 0.36},
    "child": {"speed": 0.8, "stride_time": 0.7, "foot": 0.13},
    "60 Hz": {"rate": 60.0},
    "250 Hz": {"rate": 250.0},
    "across": {"heading": 2.0},
    "turn": {"turn": 2.0, "cycles": 6},
    "treadmill": {"belt": True, "heading": -1.0},
    "slow treadmill": {"belt": True, "speed": 0.5, "stride_time": 1.7, "stance": 0.68},
    "backward": {"backward": True},
    "noisy": {"noise": 0.002},
}


@pytest.mark.parametrize("name", WALKS)
def test_made_walker(name):
    time, heel, toe, pelvis, truth = walker(**WALKS[name])
    events = detect_gait_events(time, heel, toe, pelvis)
    errors, missed, invented = compare(events, truth)
    assert not invented
    assert not [e for e in missed if time[0] + 0.15 < e[0] < time[-1] - 0.15]
    for kind in errors:
        assert np.mean(np.abs(errors[kind])) < 0.025


def test_ground_is_found():
    time, heel, toe, _, _ = walker(belt=True, speed=1.3)
    np.testing.assert_allclose(
        ground_velocity(time, heel, toe), np.tile([-1.3, 0, 0], (len(time), 1)), atol=0.05
    )
    time, heel, toe, _, _ = walker()
    assert not ground_velocity(time, heel, toe).any()


def test_no_events_without_gait():
    time = np.arange(300) / 100
    still = np.zeros((300, 2, 3))
    still[:, :, 1] = [0.1, -0.1]
    toe = still + [0.2, 0, 0]
    noise = 0.001 * np.random.default_rng(1).standard_normal((2, 300, 2, 3))
    assert detect_gait_events(time, still + noise[0], toe + noise[1]) == ()
    # A standing jump half a metre forward: both feet in the air together.
    part = np.clip((time - 1.0) / 0.5, 0, 1)
    jump = np.stack([0.5 * part, 0 * part, 0.3 * np.sin(np.pi * part)], axis=1)[:, None]
    assert detect_gait_events(time, still + jump, toe + jump, jump[:, 0]) == ()
    # One foot put 15 cm forward while the pelvis stays.
    move = np.zeros((300, 2, 3))
    move[:, 0, 0] = 0.15 * part
    assert detect_gait_events(time, still + move, toe + move, np.zeros((300, 3))) == ()


def test_gaps():
    time, heel, toe, pelvis, truth = walker(cycles=6)
    whole = detect_gait_events(time, heel, toe, pelvis)
    heel[200:205, 0] = np.nan  # short: closed
    toe[400:480, 1] = np.nan  # long: its foot is unknown there
    events = detect_gait_events(time, heel, toe, pelvis)
    left = [[e.time for e in x if e.side == "l"] for x in (events, whole)]
    assert left[0] == pytest.approx(left[1], abs=0.01)
    assert not [e for e in events if e.side == "r" and 4.0 < e.time < 4.8]
    heel[:] = np.nan
    assert detect_gait_events(time, heel, toe, pelvis) == ()


def test_alternation():
    time, heel, toe, pelvis, _ = walker(cycles=8, noise=0.003, seed=3)
    events = detect_gait_events(time, heel, toe, pelvis)
    for side in "lr":
        kinds = [e.kind for e in events if e.side == side]
        assert all(a != b for a, b in zip(kinds, kinds[1:], strict=False))


def test_bad_input():
    with pytest.raises(ParameterError, match="increase"):
        detect_gait_events(np.zeros(9), np.zeros((9, 2, 3)), np.zeros((9, 2, 3)))


def test_contacts():
    time = np.arange(3000) / 1000
    force = np.where((time > 0.5) & (time < 1.2), 700.0, 0.0) + 8.0  # an offset
    force += np.where(time < 0.1, 300.0, 0) + np.where((time > 2) & (time < 2.02), 60.0, 0)
    contacts = contact_events(time, force)
    assert [c.start is None for c in contacts] == [True, False]
    assert contacts[1].start == pytest.approx(0.5, abs=0.01)
    assert contacts[1].stop == pytest.approx(1.2, abs=0.01)


def test_partial_hits_are_left_out():
    time = np.arange(200) / 100
    heel, toe = np.zeros((200, 2, 3)), np.zeros((200, 2, 3))
    heel[:, 0, 0], toe[:, 0, 0] = -0.05, 0.15  # left heel behind the plate's edge
    heel[:, 1, :2], toe[:, 1, :2] = (3.0, 0.0), (3.2, 0.0)
    loaded = (time > 0.5) & (time < 1.2)
    force = np.zeros((200, 3))
    force[:, 2] = 600.0 * loaded
    cop = np.tile([0.1, 0.0, 0.0], (200, 1))
    corners = np.array([[0, -0.3, 0], [0.6, -0.3, 0], [0.6, 0.3, 0], [0, 0.3, 0.0]])
    plate = ForcePlate("1", time, force, cop, np.zeros(200), corners)
    assert [(e.side, e.kind) for e in plate_events([plate], time, heel, toe)] == [("l", "toe_off")]


FILES = {
    "HC038A11.c3d": ("HEE", "TOE"),
    "HC038A27.c3d": ("HEE", "TOE"),
    "HC032A03.c3d": ("HEE", "TOE"),
    "gaitalytics_treadmill_events.c3d": ("HEE", "MT2"),
}


@pytest.mark.parametrize("name", FILES)
def test_against_stored_events(data, name):
    file = ezc3d.c3d(str(data / "c3d" / name))
    group = file["parameters"]["POINT"]
    labels = list(group["LABELS"]["value"]) + list(group.get("LABELS2", {"value": []})["value"])
    points = file["data"]["points"][:3].transpose(2, 1, 0) / 1000
    header = file["header"]["points"]
    time = (header["first_frame"] + np.arange(len(points))) / header["frame_rate"]
    heel, toe = (
        np.stack([points[:, labels.index(side + n)] for side in "LR"], axis=1) for n in FILES[name]
    )
    stored = file["parameters"]["EVENT"]
    truth = [
        (60 * a + b, side[0].lower(), "heel_strike" if "Strike" in label else "toe_off")
        for a, b, side, label in zip(
            *stored["TIMES"]["value"],
            stored["CONTEXTS"]["value"],
            stored["LABELS"]["value"],
            strict=True,
        )
    ]
    errors, missed, invented = compare(detect_gait_events(time, heel, toe), truth)
    assert not missed and not invented
    for kind in errors:
        assert np.mean(np.abs(errors[kind])) <= 0.020
