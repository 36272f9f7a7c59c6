"""Plates that lie: an offset, a baseline, two feet on one plate, a shifted clock."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import Trial, analyse
from plantigrade.analyze.body_mass import weigh_jumps
from plantigrade.dynamics.plates import FootForces
from plantigrade.kinematics.result import Fit
from plantigrade.motion import ForcePlate
from plantigrade.motion.events import detect_gait_events
from plantigrade.motion.plate_events import plate_events
from plantigrade.workflows.fit import fit_recording, load
from plantigrade.workflows.settings import FitSettings


def fitted(path) -> Fit:
    """Return a recording fitted as a user's is."""
    settings = FitSettings()
    return fit_recording(load(path, settings), settings)


@pytest.fixture(scope="module")
def walk(data) -> Fit:
    """A walk over two plates."""
    return fitted(data / "c3d" / "HC038A11.c3d")


@pytest.fixture(scope="module")
def belts(data) -> Fit:
    """A walk whose plates say whose foot they hold."""
    return fitted(data / "opensim" / "rajagopal_walk" / "markers_walk.trc")


@pytest.fixture(scope="module")
def long_walk(data) -> Fit:
    """A walk that is on plates throughout."""
    return fitted(data / "opensim" / "gait2392_subject01" / "subject01_walk1.trc")


def damaged(fit: Fit, change, **more) -> Trial:
    """Analyse a fit with every plate changed."""
    plates = tuple(change(plate) for plate in fit.recording.plates)
    return analyse(replace(fit, recording=replace(fit.recording, plates=plates, **more)))


def moved(plate: ForcePlate, by) -> ForcePlate:
    corners = None if plate.corners is None else plate.corners + by
    return replace(plate, cop=plate.cop + by, corners=corners)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["walk", "belts"])
def test_good_plates_are_used(name, request):
    trial = analyse(request.getfixturevalue(name))
    assert not [use.problem for use in trial.forces.uses if use.problem]
    assert not any("clock" in note or "outside" in note for note in trial.notes)


@pytest.mark.parametrize("by", [(0.15, 0, 0), (0, 0.15, 0), (-0.15, 0, 0), (0, -0.15, 0)])
@pytest.mark.parametrize("name", ["walk", "belts"])
def test_plates_fifteen_centimetres_off_are_left_out(name, by, request):
    trial = damaged(request.getfixturevalue(name), lambda plate: moved(plate, np.array(by, float)))
    assert all(use.problem for use in trial.forces.uses if use.peak > 200)
    assert any("outside the sole" in note or "beside" in note for note in trial.notes)
    loaded = trial.forces.force[..., 2] > 100
    assert not (loaded & trial.forces.valid_side).any()
    assert trial.events_from_plates == 0


def test_a_clock_fifty_milliseconds_late_is_noted(walk):
    late = damaged(walk, lambda plate: replace(plate, time=plate.time + 0.05))
    said = [note for note in late.notes if "force plates seem" in note]
    assert said and "late" in said[0]
    assert late.events_from_plates == 0


@pytest.mark.parametrize(
    "late",
    [0.01, *(pytest.param(x, marks=pytest.mark.slow) for x in (0.006, 0.02, -0.006, -0.01, -0.02))],
)
def test_a_clock_some_milliseconds_off_is_set_right(long_walk, late):
    good = analyse(long_walk)
    other = damaged(long_walk, lambda plate: replace(plate, time=plate.time + late))
    assert other.figures["plate_clock_offset_ms"] == pytest.approx(1e3 * late, abs=2.0)
    assert any("clock of the force plates" in note and "corrected" in note for note in other.notes)
    both = np.asarray(good.forces.valid & other.forces.valid)
    both[[0, -1]] = False  # up to the ends of the plates' clock
    off = good.forces.force[both] - other.forces.force[both]
    assert np.sqrt((off[..., 2] ** 2).mean()) < 0.02 * 9.81 * good.fit.human.mass
    for a, b in zip(good.motion.events, other.motion.events, strict=True):
        assert b.time == pytest.approx(a.time, abs=0.004)


def test_a_clock_that_is_right_is_left_alone(long_walk, walk):
    """A body whose soft parts swing is late in the vertical force alone, which is no clock."""
    for fit in (long_walk, walk):
        trial = analyse(fit)
        assert abs(trial.figures.get("plate_clock_offset_ms", 0.0)) < 4
        assert not any("clock" in note for note in trial.notes)


def test_two_feet_on_one_plate_are_given_to_neither(walk):
    """Both plates of a walk as one big plate: only while one foot stands alone is it known."""
    one, two = walk.recording.plates
    force = one.force + two.force
    moment = sum(np.cross(np.nan_to_num(p.cop), p.force) for p in (one, two))
    moment[:, 2] += one.free_moment + two.free_moment
    up = force[:, 2] > 10
    with np.errstate(all="ignore"):
        cop = np.stack([-moment[:, 1] / force[:, 2], moment[:, 0] / force[:, 2], 0 * up], axis=1)
    cop[~up] = np.nan
    both = ForcePlate("1", one.time, force, cop, np.zeros(len(force)))
    trial = analyse(replace(walk, recording=replace(walk.recording, plates=(both,))))
    assert any("both feet were on it" in use.problem for use in trial.forces.uses)
    apart = analyse(walk).forces
    double = (apart.force[..., 2] > 150).all(axis=1)
    assert not trial.forces.valid_side[double].any()


def test_half_a_foot_on_a_plate_is_seen_by_its_load(walk):
    """Without corners nothing tells where the plate ends; the other plate tells the weight."""
    first, second = (replace(plate, corners=None) for plate in walk.recording.plates)
    half = replace(second, force=0.5 * second.force)
    fit = replace(walk, recording=replace(walk.recording, plates=(first, half)))
    uses = {use.plate: use.problem for use in analyse(fit).forces.uses}
    assert not uses[first.name] and "of the weight" in uses[half.name]


@pytest.mark.slow
def test_body_mass_is_weighed_where_the_person_is_carried(data):
    folder = data / "opensim" / "opencap_subject4"
    jump = analyse(fitted(folder / "DJ1.trc"))  # a landing from a box, and a jump
    assert jump.weighed is not None and jump.weighed.method == "jumps"
    assert jump.weighed.mass == pytest.approx(60.0, rel=0.04)
    # No plate measures the box, on which the person stands for a second.
    assert jump.forces is not None and jump.ground is not None
    stands = jump.motion.time - jump.motion.time[0] < 0.7
    assert not jump.forces.valid_side[stands].any()
    lift = jump.ground.forces.force[stands, :, 2].sum(axis=1) / jump.fit.human.mass / 9.81
    assert lift.mean() == pytest.approx(0.95, abs=0.05)  # it begins to bend
    assert any("on a box 30 cm high" in note and "steps:30" in note for note in jump.notes)
    still = analyse(fitted(folder / "static1.trc"))
    assert still.weighed is not None and still.weighed.method == "standing"
    assert still.fit.human.mass == pytest.approx(60.0, rel=0.01)


def test_a_jump_weighs_the_person_from_one_flight_to_the_next():
    time = np.arange(0.0, 1.5, 0.01)
    on = (time > 0.4) & (time < 1.0)
    lift = np.where(on, 9.81 + 8.0 * np.sin(7.0 * time), 0.0)
    push = np.zeros((len(time), 2, 3))
    push[:, :, 2] = 31.0 * lift[:, None]
    known = np.ones((len(time), 2), dtype=bool)
    forces = FootForces(push, push, push, known, known.all(axis=1))
    weighed = weigh_jumps(time, forces, lift)
    assert weighed is not None and weighed.mass == pytest.approx(62.0)
    assert weighed.seconds == pytest.approx(0.6, abs=0.02)
    later = slice(50, None)  # it lands unseen
    assert weigh_jumps(time[later], forces.frames(later), lift[later]) is None


@pytest.mark.slow
def test_the_chair_carries_a_part_of_a_sitting_person(data):
    seated = analyse(fitted(data / "opensim" / "opencap_subject4" / "STS1.trc"))
    assert seated.weighed is None or seated.weighed.mass == pytest.approx(60.0, rel=0.03)


def test_the_mass_of_a_walker_is_that_of_the_scales(walk):
    """The file gives 56.8 kg."""
    unknown = replace(walk.recording.subject, mass=None)
    trial = analyse(replace(walk, recording=replace(walk.recording, subject=unknown)))
    assert trial.weighed is not None and trial.weighed.method == "gait"
    assert trial.fit.human.mass == pytest.approx(56.8, rel=0.02)


@pytest.mark.parametrize(
    ("name", "marks", "limit"),
    [
        ("c3d/HC038A11.c3d", ("HEE", "TOE"), 0.015),
        ("opensim/running_subject04/run300.trc", ("CAL", "TOE"), 0.02),
    ],
)
def test_noise_of_a_millimetre_moves_events_little(data, name, marks, limit):
    """Against plates that were stored as measured."""
    recording = load(data / name, FitSettings())
    markers = recording.markers
    noise = np.random.default_rng(4).normal(0, 0.001, markers.positions.shape)
    seen = replace(markers, positions=markers.positions + noise)
    heel, toe = (
        np.stack([seen.positions[:, seen.index(side + mark)] for side in "RL"], axis=1)
        for mark in marks
    )
    events = detect_gait_events(seen.time, heel, toe)
    truth = plate_events(recording.plates, seen.time, heel, toe)
    errors = []
    for each in truth:
        same = [e for e in events if (e.side, e.kind) == (each.side, each.kind)]
        if seen.time[0] + 0.1 < each.time < seen.time[-1] - 0.1:
            errors.append(min((abs(e.time - each.time) for e in same), default=1.0))
    assert len(errors) >= 4 and np.mean(errors) < limit
