"""The chair that a fit finds carries a person in a simulation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.contact.ground import Seat
from plantigrade.contact.limb_sites import cushioned_sites
from plantigrade.contact.site import CHAIR_PART, ContactSite
from plantigrade.dynamics.loading import SEAT_COMPRESSION
from plantigrade.record import Record, Run
from plantigrade.workflows.recorded_seat import with_cushion
from plantigrade.world import World

STORED = Path(__file__).parents[1] / "stored" / "sit-to-stand"


@pytest.fixture(scope="module")
def planned() -> Record:
    """A planned rise from a chair, on two ischia."""
    return Run.load(STORED).record


def as_fitted(record: Record) -> Record:
    """Return a record with one force on its seat, as a fit finds it."""
    assert record.contact_force is not None and record.contact_point is not None
    feet = [i for i, site in enumerate(record.sites) if site.side]
    seats = [i for i, site in enumerate(record.sites) if not site.side]
    force, point = record.contact_force, record.contact_point
    x, y, z = (float(each) for each in np.mean([s.position for s in record.ground.seats], axis=0))
    one = ContactSite(body="pelvis", name="seat", part=CHAIR_PART, measured=True)
    return replace(
        record,
        sites=(*(record.sites[i] for i in feet), one),
        ground=replace(record.ground, seats=(Seat("seat", (x, y, z)),)),
        contact_force=np.concatenate(
            [force[:, feet], force[:, seats].sum(axis=1, keepdims=True)], axis=1
        ),
        contact_point=np.concatenate([point[:, feet], point[:, seats[:1]]], axis=1),
        contact_torque=None,
        contact_known=None,
        contact_planned=None,
    )


def test_one_force_on_a_seat_becomes_four_points_on_a_cushion(planned):
    fitted = as_fitted(planned)
    found = with_cushion(fitted)
    assert fitted.contact_force is not None and found.contact_force is not None
    assert fitted.contact_point is not None and found.contact_point is not None
    own = {seat.site: seat for seat in found.ground.seats}
    assert set(own) == {"seat_r", "seat_l", "seat_rear_r", "seat_rear_l"}
    for seat in planned.ground.seats:
        height = own[seat.site].position[2] - SEAT_COMPRESSION
        assert height == pytest.approx(seat.position[2], abs=0.01)
        assert (own[seat.site].stiffness or 0.0) > 0.0
    np.testing.assert_allclose(found.contact_force.sum(axis=1), fitted.contact_force.sum(axis=1))
    # One board carries them all: two that overlap would be twice as stiff.
    sites = cushioned_sites(found.human)
    world = World(found.human, found.ground, sites=sites, recording=False)
    names = [world.model.geom(i).name for i in range(world.model.ngeom)]
    assert sum(name.startswith("seat_") for name in names) == 1
    # Where the centre of pressure is between the rows, it stays.
    points, force = found.contact_point[:, -4:, 0], found.contact_force[:, -4:, 2]
    sits, total = force.sum(axis=1) > 0.0, np.maximum(force.sum(axis=1), 1e-9)
    behind = replace(fitted, contact_point=fitted.contact_point - [0.03, 0.0, 0.0])
    moved = with_cushion(behind)
    assert moved.contact_force is not None
    after = (moved.contact_force[:, -4:, 2] * points).sum(axis=1) / total
    before = (force * points).sum(axis=1) / total
    assert -0.032 < np.median((after - before)[sits]) < -0.015


def test_what_has_no_such_seat_stays_as_it_is(planned):
    assert with_cushion(planned) is planned


@pytest.mark.slow
def test_a_recorded_person_rises_from_the_chair_and_sits_down_again_five_times(data):
    run = pg.simulate(data / "opensim/opencap_subject4/STS1.trc")
    record = run.record
    time, pelvis = record.motion.time, record.motion.qpos[:, 2]
    assert time[-1] > 13.9 and not any("fell" in note for note in record.notes)
    stands, hip = np.flatnonzero(np.diff((pelvis > 0.8).astype(int)) > 0), np.median(pelvis[:60])
    assert len(stands) == 5
    for rise in stands[1:]:  # the person sits before each of them
        assert abs(pelvis[rise - 90 : rise].min() - hip) < 0.05
    assert record.contact_force is not None
    seat = [site.part == CHAIR_PART for site in record.sites]
    load = record.contact_force[:, seat, 2].sum(axis=1) / record.weight
    assert load[(time > 0.2) & (time < 0.6)].mean() > 0.6
    assert load[(time > 1.2) & (time < 1.8)].max() == 0.0
