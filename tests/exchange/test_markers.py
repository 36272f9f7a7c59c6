"""Virtual motion capture: what a laboratory's files of a run hold, read back."""

from dataclasses import replace

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.errors import ParameterError
from plantigrade.io import read
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers
from plantigrade.record import Run
from tests.exchange.moving import moving


def about_origin(plate, k) -> np.ndarray:
    """Return force and moment about the origin in some samples of a plate."""
    force, free = plate.force[k], np.outer(plate.free_moment[k], [0.0, 0.0, 1.0])
    return np.hstack([force, np.cross(plate.cop[k], force) + free])


def test_c3d_holds_markers_forces_events_and_the_person(walk, tmp_path):
    path = tmp_path / "walk.c3d"
    assert walk.export(path) == ()
    found, record = read(path), walk.record
    motion, human = record.motion, record.human
    assert found.subject.mass == pytest.approx(human.mass)
    assert found.subject.height == pytest.approx(human.height)
    shift = found.markers.time[0] - motion.time[0]
    expected = [(e.side, e.kind, pytest.approx(e.time + shift, abs=1e-4)) for e in motion.events]
    assert [(e.side, e.kind, e.time) for e in found.events] == expected
    heel = attachments(human)["heel_r"]
    assert found.markers.select(["RHEE"]).positions == pytest.approx(
        PointSet.of(human, [heel]).path(motion.qpos), abs=1e-5
    )
    assert len(found.plates) == 2
    for side, plate in zip("rl", found.plates, strict=True):
        foot = record.foot(side)
        k = foot.force[:, 2] > 0.05 * record.weight
        place = np.where(k[:, None], foot.centre_of_pressure, 0.0)[k]
        moment = np.cross(place, foot.force[k]) + foot.torque[k]
        expected = np.hstack([foot.force[k], moment])
        assert about_origin(plate, k) == pytest.approx(expected, abs=2e-3 * record.weight)
        low, high = plate.corners.min(axis=0), plate.corners.max(axis=0)
        inside = plate.cop[k][:, :2]
        assert (inside > low[:2]).all() and (inside < high[:2]).all()


def test_recorded_markers_keep_their_names_and_lie_on_the_body(walk, tmp_path):
    record, n = walk.record, walk.record.motion.n_frames
    time = record.motion.time
    places = np.random.default_rng(0).normal(0, 0.1, (n, 2, 3)) + [1.0, 2.0, 3.0]
    record = replace(
        record, recorded_markers=Markers(("A1", "B2"), time, places + 0.01), fitted_markers=places
    )
    replace(walk, record=record).export(tmp_path / "walk.trc")
    markers = read(tmp_path / "walk.trc").markers
    assert markers.names == ("A1", "B2")
    assert markers.positions == pytest.approx(places, abs=1e-6)
    replace(walk, record=record).export(tmp_path / "walk.trc", marker_set="gait2392")
    assert "R.ASIS" in read(tmp_path / "walk.trc").markers.names


def test_trc_and_coordinates_have_a_file_of_forces(walk, tmp_path):
    for name in ("walk.trc", "walk.mot"):
        (note,) = walk.export(tmp_path / name)
        assert note == "the ground reactions were written to walk_grf.mot"
        right, left = read(tmp_path / "walk_grf.mot").plates
        assert right.force == pytest.approx(walk.record.foot("r").force, abs=0.01)
        assert (right.side, left.side) == ("r", "l")
        (tmp_path / "walk_grf.mot").unlink()
    knee = read(tmp_path / "walk.mot").coordinates["knee_angle_r"]
    assert knee == pytest.approx(walk.record.motion["knee_angle_r"], abs=1e-6)


def test_a_clock_of_unequal_steps_becomes_even(tmp_path):
    """A motion between the nodes of an optimised one; C3D and BVH know one rate only."""
    run = moving(Human.create(), n=9)
    motion = run.record.motion
    uneven = replace(motion, time=motion.time + 0.004 * np.sin(np.arange(9)))
    run = Run(replace(run.record, motion=uneven), "synthesize")
    (note,) = run.export(tmp_path / "run.c3d")
    assert note == "the run holds no ground reactions"
    markers = read(tmp_path / "run.c3d").markers
    assert np.diff(markers.time) == pytest.approx(np.diff(markers.time)[0], abs=1e-4)
    run.export(tmp_path / "slow.c3d", rate=20)
    assert read(tmp_path / "slow.c3d").markers.rate == pytest.approx(20)


def test_marker_sets_are_checked(walk, tmp_path):
    with pytest.raises(ParameterError, match="'helen' is not known; allowed are plug-in-gait"):
        walk.export(tmp_path / "walk.c3d", marker_set="helen")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_fit_of_virtual_markers_finds_the_motion_again(data, tmp_path):
    """Angles of pelvis and legs are found within half a degree, forces within a percent."""
    run = pg.fit(data / "c3d/HC038A11.c3d")
    human = run.record.human
    run.export(tmp_path / "again.c3d", marker_set="oxford-foot-model")
    again = pg.fit(tmp_path / "again.c3d", height=human.height, mass=human.mass)
    one, two = run.record, again.record
    legs = ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle")
    names = [f"{name}_{side}" for name in legs for side in "rl"]
    for name in ("pelvis_tilt", "pelvis_list", "pelvis_rotation", *names):
        off = np.rad2deg(two.motion[name] - one.motion[name])
        assert np.sqrt(np.mean(off**2)) < 0.5, name
    for side in "rl":
        a, b = one.foot(side), two.foot(side)
        known = a.measured & b.measured
        assert known.mean() > 0.5
        rms = np.sqrt(np.mean((a.force - b.force)[known] ** 2))
        assert rms < 0.01 * one.weight
        assert b.force[known, 2].max() == pytest.approx(a.force[known, 2].max(), rel=0.01)
