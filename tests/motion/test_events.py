import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.motion import ForcePlate, GaitEvent
from plantigrade.motion.events import detect_gait_events
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.plate_events import contact_events, plate_events
from tests.motion.walkers import compare, walker

WALKS = {
    "usual": {},
    "slow": {"speed": 0.5, "stride_time": 1.7, "stance": 0.68},
    "fast": {"speed": 2.2, "stride_time": 0.85, "stance": 0.56},
    "runner": {"speed": 3.5, "stride_time": 0.7, "stance": 0.36, "runs": True},
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
    # These feet leave at once; the threshold waits until they are as fast as people's feet then.
    for kind, limit in (("heel_strike", 0.015), ("toe_off", 0.03)):
        assert np.mean(np.abs(errors[kind])) < limit


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
    heel[200:205, 1] = np.nan  # short: closed
    toe[400:480, 0] = np.nan  # long: its foot is unknown there
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
    heel[:, 1, 0], toe[:, 1, 0] = -0.05, 0.15  # left heel behind the plate's edge
    heel[:, 0, :2], toe[:, 0, :2] = (3.0, 0.0), (3.2, 0.0)
    loaded = (time > 0.5) & (time < 1.2)
    force = np.zeros((200, 3))
    force[:, 2] = 600.0 * loaded
    cop = np.tile([0.1, 0.0, 0.0], (200, 1))
    corners = np.array([[0, -0.3, 0], [0.6, -0.3, 0], [0.6, 0.3, 0], [0, 0.3, 0.0]])
    plate = ForcePlate("1", time, force, cop, np.zeros(200), corners)
    assert [(e.side, e.kind) for e in plate_events([plate], time, heel, toe)] == [("l", "toe_off")]


def hops(paths, *, flight=0.35, rest=0.15, height=0.12, n=6, rate=100.0):
    """Return time, heel, toe, pelvis of feet that fly n times, `paths` metres ahead each.

    A foot whose path is None is held up and travels with the pelvis.
    """
    time = np.arange(int((n * (flight + rest) + 0.6) * rate)) / rate
    cycle = (time - 0.3) / (flight + rest)
    number = np.clip(np.floor(cycle), 0, n - 1)
    part = np.clip(((cycle - number) * (flight + rest) - rest) / flight, 0, 1)
    gone = 0.3 * part + 0.35 * (1 - np.cos(np.pi * part))
    mean = max(p or 0.0 for p in paths) / (flight + rest)
    x_pelvis = mean * np.clip(time - 0.3, 0, n * (flight + rest))
    heel = np.zeros((len(time), 2, 3))
    for k, path in enumerate(paths):
        heel[:, k, 1] = 0.2 * k - 0.1
        heel[:, k, 0] = x_pelvis - 0.2 if path is None else path * (number + gone)
        heel[:, k, 2] = 0.3 if path is None else 4 * height * part * (1 - part)
    toe = heel + [0.2, 0, 0]
    pelvis = np.stack([x_pelvis, 0 * time, 0.9 + 4 * height * part * (1 - part)], axis=1)
    return time, heel, toe, pelvis


HOPS = {
    "jumps ahead": {"paths": (0.7, 0.7)},
    "quick low jumps": {"paths": (0.4, 0.4), "flight": 0.25, "height": 0.05},
    "hops on the left foot": {"paths": (None, 0.7)},
    "hops on the right foot": {"paths": (0.9, None), "flight": 0.28},
    "jumps on the spot": {"paths": (0.0, 0.0)},
    "kicks of one foot": {"paths": (0.0, 0.15), "height": 0.4},
    "one foot put ahead again and again": {"paths": (0.0, 0.4), "height": 0.03},
}


@pytest.mark.parametrize("name", HOPS)
def test_hops_are_no_steps(name):
    assert detect_gait_events(*hops(**HOPS[name])) == ()


def test_a_leap_is_no_running_step():
    runner = {"speed": 2.5, "stance": 0.36, "runs": True}
    for stride_time, found in ((0.8, True), (2.4, False)):  # 0.11 and 0.34 s in the air
        time, heel, toe, pelvis, _ = walker(**runner, stride_time=stride_time)
        assert bool(detect_gait_events(time, heel, toe, pelvis)) == found


def test_a_jump_of_the_collection(data):
    from plantigrade.workflows.fit import fit_trial

    jump = fit_trial(data / "cmu_asfamc" / "02_04.amc")[1]
    assert jump.motion.events == ()


@pytest.mark.slow
def test_kicks_and_hops_of_the_collection(data):
    from plantigrade.workflows.fit import fit_trial

    # Kicks, a leap and a few real steps: each lands well after the other foot's.
    hop = fit_trial(data / "cmu_asfamc" / "131_03.amc")[1].record().motion.events
    landings = [e for e in hop if e.kind == "heel_strike"]
    assert not [e for e in hop if 1.0 < e.time < 2.0 or 6.0 < e.time < 7.3]  # kick, leap
    for a, b in zip(landings, landings[1:], strict=False):
        assert b.time - a.time > 0.12


def plate(force, time, corners=None):
    forces = np.zeros((len(time), 3))
    forces[:, 2] = force
    return ForcePlate("1", time, forces, np.tile([0.1, 0, 0], (len(time), 1)), 0 * time, corners)


def standing_left(n=200):
    """Return heel and toe: the left foot on the plate, the right one far away."""
    heel, toe = np.zeros((n, 2, 3)), np.zeros((n, 2, 3))
    toe[:, 1, 0] = 0.2
    heel[:, 0, :2], toe[:, 0, :2] = (3.0, 0.0), (3.2, 0.0)
    return heel, toe


def test_a_creeping_force_is_no_edge():
    time = np.arange(2000) / 1000
    heel, toe = standing_left()
    frames = time[::10]
    clean = 700 * np.clip((time - 0.5) / 0.03, 0, 1) * np.clip((1.2 - time) / 0.06, 0, 1)
    found = plate_events([plate(clean, time)], frames, heel, toe)
    assert [e.kind for e in found] == ["heel_strike", "toe_off"]
    assert [e.time for e in found] == pytest.approx([0.5, 1.2], abs=0.01)
    # As the foot leaves, a tenth of the weight lingers and fades: something else loads the plate.
    lingering = clean + 70 * (time > 1.1) * np.clip((1.5 - time) / 0.3, 0, 1)
    found = plate_events([plate(lingering, time)], frames, heel, toe)
    assert [e.kind for e in found] == ["heel_strike"]
    found = plate_events([plate(lingering[::-1], time)], frames, heel, toe)
    assert [e.kind for e in found] == ["toe_off"]


def test_the_other_foot_on_the_plate_spoils_the_edge():
    time = np.arange(2000) / 1000
    heel, toe = standing_left()
    heel[:, 0, :2], toe[:, 0, :2] = (0.3, -0.01), (0.5, -0.05)  # its heel just over the edge
    force = 700.0 * ((time > 0.5) & (time < 1.2))
    corners = np.array([[-0.2, -0.02, 0], [0.6, -0.02, 0], [0.6, 0.5, 0], [-0.2, 0.5, 0]])
    assert plate_events([plate(force, time, corners)], time[::10], heel, toe) == ()
    heel[:, 0, 1], toe[:, 0, 1] = -0.05, -0.09
    assert len(plate_events([plate(force, time, corners)], time[::10], heel, toe)) == 2


def test_the_toe_tip_must_leave_inside_the_plate():
    time = np.arange(2000) / 1000
    heel, toe = standing_left()
    force = 700.0 * ((time > 0.5) & (time < 1.2))
    for end, kinds in ((0.21, ["heel_strike"]), (0.3, ["heel_strike", "toe_off"])):
        corners = np.array([[-0.2, -0.3, 0], [end, -0.3, 0], [end, 0.3, 0], [-0.2, 0.3, 0]])
        found = plate_events([plate(force, time, corners)], time[::10], heel, toe)
        assert [e.kind for e in found] == kinds


def test_a_filtered_plate_is_not_read_in_its_ringing():
    from scipy.signal import butter, sosfiltfilt

    time = np.arange(4000) / 1000
    true = 700 * np.clip((time - 1.0) / 0.05, 0, 1) * np.clip((2.0 - time) / 0.15, 0, 1)
    smoothed = sosfiltfilt(butter(4, 8.0, output="sos", fs=1000), true)
    assert smoothed.min() < -5  # the ground seems to pull
    heel, toe = standing_left(400)
    found = plate_events([plate(smoothed, time)], time[::10], heel, toe)
    plain = contact_events(time, smoothed)[0]
    assert abs(found[0].time - 1.0) < abs(plain.start - 1.0)
    assert [e.time for e in found] == pytest.approx([1.0, 2.0], abs=0.02)


FILES = {
    "HC038A11.c3d": ("HEE", "TOE"),
    "HC038A27.c3d": ("HEE", "TOE"),
    "HC032A03.c3d": ("HEE", "TOE"),
    "gaitalytics_treadmill_events.c3d": ("HEE", "MT2"),
}


@pytest.mark.parametrize("name", FILES)
def test_against_stored_events(data, name):
    file = pytest.importorskip("ezc3d").c3d(str(data / "c3d" / name))
    group = file["parameters"]["POINT"]
    labels = list(group["LABELS"]["value"]) + list(group.get("LABELS2", {"value": []})["value"])
    points = file["data"]["points"][:3].transpose(2, 1, 0) / 1000
    header = file["header"]["points"]
    time = (header["first_frame"] + np.arange(len(points))) / header["frame_rate"]
    heel, toe = (
        np.stack([points[:, labels.index(side + n)] for side in "RL"], axis=1) for n in FILES[name]
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
    for kind in errors:  # where no plate was, the file's were set by hand, to 10 or 20 ms
        assert np.mean(np.abs(errors[kind])) <= 0.025


def test_a_plate_stored_smooth_is_no_clock():
    """A low-pass before storing moves the landing forward; the motion is believed instead."""
    from plantigrade.motion.event_sources import as_measured, clock_shift, with_measured
    from plantigrade.motion.filters import lowpass

    time = np.arange(3000) / 1000
    # The heel strikes with 150 N within 10 ms, then the load comes on.
    true = 150 * np.clip((time - 1.0) / 0.01, 0, 1) + 550 * np.clip((time - 1.01) / 0.12, 0, 1)
    true *= np.clip((2.0 - time) / 0.1, 0, 1)
    sharp = plate(true, time)
    smooth = plate(lowpass(time, true, cutoff=10.0), time)
    early = contact_events(time, smooth.force[:, 2])[0].start
    assert early < 0.995 < contact_events(time, true)[0].start
    assert as_measured([sharp]) == (sharp,) and as_measured([smooth]) == ()

    seen = [GaitEvent(1.0, "l", "heel_strike"), GaitEvent(2.0, "l", "toe_off")]
    moved = [GaitEvent(e.time + 0.008, e.side, e.kind) for e in seen]
    assert with_measured(moved, seen) == (tuple(seen), 2)
    assert clock_shift(moved, seen) is None
    late = [GaitEvent(e.time - 0.05, e.side, e.kind) for e in seen]
    assert clock_shift(late, seen) == pytest.approx(0.05)
    # Early landings and late lift-offs are a smooth force, not a shifted clock.
    wide = [GaitEvent(1.03, "l", "heel_strike"), GaitEvent(1.97, "l", "toe_off")]
    assert clock_shift(wide, seen) is None


def test_a_runner_is_recognised_and_timed():
    from plantigrade.motion.event_timing import is_running

    for name in ("usual", "fast", "runner"):
        time, heel, toe, pelvis, _ = walker(**WALKS[name])
        assert is_running(detect_gait_events(time, heel, toe, pelvis)) == (name == "runner")


def test_baselines():
    from plantigrade.motion.plate_baseline import unloaded

    time = np.arange(4000) / 1000
    noise = np.random.default_rng(1).normal(0, 2, len(time))
    step = 700.0 * ((time > 1) & (time < 1.7))
    assert unloaded(time, step + noise) is None
    for level in (-15.0, 12.0):
        found = unloaded(time, step + level + noise)
        assert found is not None and not found[(time > 0.98) & (time < 1.72)].any()
        assert np.median((step + level + noise)[found]) == pytest.approx(level, abs=0.5)
    # A person who sits leaves some weight on the feet, and rises slowly: that is a load.
    rise = 20 + 350 * np.clip((time - 1.5) / 0.6, 0, 1)
    assert unloaded(time, rise + noise) is None
