"""A gait held against a recorded one: known changes of the recorded one come back as figures."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import Comparison, compare
from plantigrade.analyze.reproduction import ROTATIONS, angles_deg, over_swings
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import ContactSite, foot_sites
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.textbook_recording import TextbookWalk, textbook_walk
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.ordered_tasks import GaitReference, GaitTasks, ReproducedGait, reference_of
from plantigrade.record import Record
from plantigrade.spatial.conventions import wxyz_to_xyzw, xyzw_to_wxyz
from plantigrade.wbc import OrderedMotion, TaskOrder

STEP = 0.005


@pytest.fixture(scope="module")
def walk() -> TextbookWalk:
    return textbook_walk(Human.create())


@pytest.fixture(scope="module")
def reference(walk) -> GaitReference:
    return reference_of(walk.human, walk.time, walk.qpos, walk.events)


def moved(reference: GaitReference, change=lambda time, qpos: qpos) -> Record:
    """The recorded gait on the ticks of a reproduced one, changed."""
    time = np.arange(reference.start, reference.stop + 1e-9, STEP)
    qpos = change(time, reference.at(time))
    n, nothing = len(time), np.zeros((len(time), reference.human.model.nv))
    motion = OrderedMotion(
        reference.human, TaskOrder([]), time, qpos, nothing, nothing, np.zeros((n, 0), dtype=bool),
        np.zeros((n, 0)), np.zeros(n), np.zeros(n), np.ones(n, dtype=bool),
    )  # fmt: skip
    return ReproducedGait(reference, GaitTasks(), motion).record()


def root(offset):
    """A change that moves the whole body [m]."""

    def change(time, qpos):
        return np.hstack([qpos[:, :3] + offset, qpos[:, 3:]])

    return change


@pytest.fixture(scope="module")
def same(reference) -> Comparison:
    return compare(moved(reference))


def test_the_recorded_gait_is_itself(same):
    for name, (ours, theirs) in same.rom.items():
        assert ours == pytest.approx(theirs, abs=0.05), name
        assert same.rmse[name] < 0.05, name
    for _, name in ROTATIONS:
        assert same.correlation[name] > 0.999
        assert same.rom[name][0] > 3, "every rotation of the table moves in walking"
    assert same.com_error_max_m < 1e-3
    assert same.contact_share > 0.9
    for side in "rl":
        assert same.clearance[side][0] == pytest.approx(same.clearance[side][1], abs=1e-3)
        assert same.swing_knee[side][0] == pytest.approx(same.swing_knee[side][1], abs=0.1)
        assert 50 < same.swing_knee[side][1] < 75, "a knee swings through at about 60 degrees"


def test_curves_have_a_row_for_each_cycle_of_their_side(same):
    count = {side: sum(c.side == side for c in same.cycles) for side in "rl"}
    assert min(count.values()) >= 1
    for name, rows in same.curves_simulated.items():
        side = name[-1] if name.endswith(("_r", "_l")) else "r"
        assert rows.shape == same.curves_reference[name].shape == (count[side], 101)


def test_a_flattened_knee_has_that_much_less_range(reference, same):
    i = 7 + reference.human.hinge("knee_angle_r")

    def flatten(time, qpos):
        qpos[:, i] = 0.8 * qpos[:, i] + 0.1
        return qpos

    found = compare(moved(reference, flatten))
    theirs = same.rom["knee_angle_r"][1]
    assert found.rom["knee_angle_r"] == pytest.approx((0.8 * theirs, theirs), abs=0.05)
    assert found.rom_error["knee_angle_r"] == pytest.approx(-0.2 * theirs, abs=0.05)
    assert found.correlation["knee_angle_r"] == pytest.approx(1, abs=1e-4)
    off = 0.2 * same.curves_reference["knee_angle_r"] - np.rad2deg(0.1)
    assert found.rmse["knee_angle_r"] == pytest.approx(np.sqrt(np.mean(off**2)), abs=0.02)
    peak = 0.8 * same.swing_knee["r"][1] + np.rad2deg(0.1)
    assert found.swing_knee["r"][0] == pytest.approx(peak, abs=0.1)
    assert found.rom["knee_angle_l"] == same.rom["knee_angle_l"]


def test_a_body_off_its_path(reference, same):
    aside = compare(moved(reference, root([0.006, 0.008, 0.0])))
    assert aside.com_error_rms_m == pytest.approx(0.010, abs=1e-3)
    assert aside.com_error_max_m == pytest.approx(0.010, abs=1e-3)
    assert aside.contact_drift_m == pytest.approx(same.contact_drift_m, abs=1e-9)
    assert aside.lowest_m == same.lowest_m
    below = compare(moved(reference, root([0.0, 0.0, -0.007])))
    assert below.lowest_m == pytest.approx(same.lowest_m - 0.007)
    for side in "rl":
        assert below.clearance[side][0] == pytest.approx(same.clearance[side][0] - 0.007)
        assert below.clearance[side][1] == same.clearance[side][1]


def test_feet_that_never_come_down_do_not_drift_but_do_not_stand(reference):
    above = compare(moved(reference, root([0.0, 0.0, 0.03])))
    assert above.contact_drift_m == 0 and above.contact_share == 0


def test_heading_does_not_matter(reference, walk, same):
    """A walk the other way round, across the jump of the heading from 180 to -180 degrees."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("z", 179.9, degrees=True)

    def turned(qpos):
        rotation = turn * Rotation.from_quat(wxyz_to_xyzw(qpos[:, 3:7]))
        return np.hstack([turn.apply(qpos[:, :3]), xyzw_to_wxyz(rotation.as_quat()), qpos[:, 7:]])

    other = reference_of(walk.human, walk.time, turned(walk.qpos), walk.events)
    found = compare(moved(other))
    for name, both in same.rom.items():
        assert found.rom[name] == pytest.approx(both, abs=0.05), name


@pytest.fixture
def standing() -> GaitReference:
    """Somebody who stands on both feet for a second and never walks."""
    human = Human.create()
    qpos = human.standing()
    qpos[2] -= sole_paths(human, qpos[None]).position[..., 2].min()
    time = np.linspace(0.0, 1.0, 101)
    many = np.tile(qpos, (len(time), 1))
    still = np.zeros((len(time), human.model.nv))
    events = textbook_walk(human).events[:3]
    first, last = (replace(events[0], time=0.0), replace(events[2], time=1.0))
    motion = Motion(time, many, still, human.joint_names, still, (first, last))
    heels = tuple(ContactInterval(side, "heel", 0.2, 0.7) for side in "rl")
    path = Trajectory.fixed(np.zeros(3))
    return GaitReference(human, motion, (), heels, heels, path, dict.fromkeys("rl", path), {})


def sliding(path):
    """A change that moves the whole body along a line by a function of time [m]."""
    return lambda time, qpos: root(np.outer(path(time), [0.6, 0.8, 0.0]))(time, qpos)


def test_drift_is_the_way_since_the_first_touch(standing):
    """Sliding at 10 mm/s over a contact of half a second; before and after it nothing counts."""
    found = compare(moved(standing, sliding(lambda t: 0.010 * t)))
    assert found.contact_drift_m == pytest.approx(0.010 * 0.5, abs=2 * 0.010 * STEP)
    assert found.contact_share == 1


def test_contacts_are_found_by_the_names_of_their_sites(standing):
    """A plan may list sites in another order, name the sphere alone, and hold a seat."""
    record = moved(standing, sliding(lambda t: 0.010 * t * (t > 0.1)))
    assert record.contact_planned is not None
    feet = foot_sites(record.human)
    order = [next(i for i, s in enumerate(record.sites) if s.name.endswith(f.name)) for f in feet]
    seat = ContactSite(body="pelvis", name="seat_r", part="chair")
    planned = np.insert(record.contact_planned[:, order], 0, values=True, axis=1)
    other = replace(
        record,
        sites=(seat, *feet),
        contact_planned=planned,
        contact_force=None,
        contact_point=None,
        contact_torque=None,
        contact_known=None,
        conditions=(),
    )
    assert compare(other).contact_drift_m == pytest.approx(compare(record).contact_drift_m)
    assert compare(other).contact_share == compare(record).contact_share == 1


def test_way_back_is_no_excuse(standing):
    """The largest way counts, also where the point is back in the end."""

    def there_and_back(t):
        return 0.004 * np.sin(np.pi * np.clip((t - 0.2) / 0.5, 0, 1))

    found = compare(moved(standing, sliding(there_and_back)))
    assert found.contact_drift_m == pytest.approx(0.004, rel=1e-3)


def test_without_a_whole_cycle_the_whole_motion_counts(standing):
    i = 7 + standing.human.hinge("knee_angle_l")

    def bend(time, qpos):
        qpos[:, i] += np.deg2rad(30) * time
        return qpos

    found = compare(moved(standing, bend))
    assert found.cycles == () and found.curves_simulated["knee_angle_l"].shape == (0, 101)
    assert found.rom["knee_angle_l"] == pytest.approx((30, 0), abs=1e-6)
    assert found.rmse["knee_angle_l"] == pytest.approx(30 / np.sqrt(3), rel=0.01)
    assert np.isnan(found.correlation["knee_angle_l"]), "what does not move correlates with nothing"
    assert "knee_angle_correlation_l" not in found.metrics()


def test_a_side_without_a_whole_cycle_takes_the_other_sides(walk, reference):
    strikes = [e for e in reference.events if e.kind == "heel_strike"]
    right = [e for e in strikes if e.side == "r"][:2]
    events = tuple(e for e in reference.events if right[0].time <= e.time <= right[1].time)
    one = reference_of(walk.human, walk.time, walk.qpos, events)
    found = compare(moved(one))
    assert [c.side for c in found.cycles] == ["r"]
    assert found.curves_simulated["knee_angle_l"].shape == (1, 101)
    assert found.metrics()["cycles_l_count"] == 0
    assert found.rom["knee_angle_l"][0] > 40


def test_swings_are_counted_one_by_one(reference):
    time = np.arange(reference.start, reference.stop, 0.001)
    lasts = over_swings(reference.phases, "r", time, time, np.ptp)
    swings = [p.duration for p in reference.phases if p.kind == "single" and p.swing == "r"]
    assert lasts == pytest.approx(np.mean(swings), abs=0.002)
    third = over_swings(reference.phases, "r", time, time, np.ptp, 1 / 3)
    assert third == pytest.approx(np.mean(swings) / 3, abs=0.003)
    early = time < reference.start - 1
    assert np.isnan(over_swings(reference.phases, "r", time[early], time[early], np.max))


def test_metrics_are_plain_figures(same):
    metrics = same.metrics()
    json.dumps(metrics, allow_nan=False)
    assert metrics["knee_angle_rom_error_r_deg"] == same.rom_error["knee_angle_r"]
    assert metrics["com_error_max_mm"] == 1e3 * same.com_error_max_m
    assert metrics["rom_error_max_deg"] == max(abs(same.rom_error[n]) for _, n in ROTATIONS)


def test_angles_are_those_of_the_coordinates(walk):
    names, values = angles_deg(walk.human, walk.qpos)
    theirs, coordinates = walk.human.to_coordinates(walk.qpos)
    for i, name in enumerate(names):
        np.testing.assert_allclose(values[:, i], np.rad2deg(coordinates[:, theirs.index(name)]))


@pytest.mark.parametrize("spoil", ["short", "nan"])
def test_nothing_to_compare(reference, spoil):
    record = moved(reference)
    if spoil == "nan":
        record.motion.qpos[3, 9] = np.nan
    else:
        motion, planned = record.motion.frames(slice(0, 1)), record.contact_planned[:1]
        record = replace(record, motion=motion, contact_planned=planned, signals={})
    with pytest.raises(ReproduceError, match="at least two finite ones"):
        compare(record)


def test_a_record_without_a_recorded_motion_is_refused(reference):
    with pytest.raises(ReproduceError, match="no recorded motion"):
        compare(replace(moved(reference), references={}))
