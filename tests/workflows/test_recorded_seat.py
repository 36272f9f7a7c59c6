"""The chair that a fit finds carries a person in a simulation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.contact.ground import Seat
from plantigrade.contact.site import CHAIR_PART, ContactSite
from plantigrade.dynamics.loading import SEAT_COMPRESSION
from plantigrade.record import Record, Run
from plantigrade.workflows.recorded_seat import with_ischia

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


def test_one_force_on_a_seat_becomes_two_ischia_on_a_cushion(planned):
    found = with_ischia(as_fitted(planned))
    own = {seat.site: seat for seat in found.ground.seats}
    assert set(own) == {"seat_r", "seat_l"}
    for seat in planned.ground.seats:
        height = own[seat.site].position[2] - SEAT_COMPRESSION
        assert height == pytest.approx(seat.position[2], abs=0.01)
        assert (own[seat.site].stiffness or 0.0) > 0.0
    assert found.contact_force is not None and planned.contact_force is not None
    np.testing.assert_allclose(
        found.contact_force.sum(axis=1), planned.contact_force.sum(axis=1), atol=1e-6
    )


def test_what_has_no_such_seat_stays_as_it_is(planned):
    assert with_ischia(planned) is planned


@pytest.mark.slow
def test_a_recorded_person_rises_from_the_chair_and_sits_down_again(data):
    run = pg.simulate(data / "opensim/opencap_subject4/STS1.trc", duration=2.9)
    record = run.record
    time, pelvis = record.motion.time, record.motion.qpos[:, 2]
    hip = [float(np.interp(t, time, pelvis)) for t in (0.5, 1.5, 2.8)]
    assert time[-1] == pytest.approx(2.9, abs=0.02)
    assert hip[1] - hip[0] > 0.35 and abs(hip[2] - hip[0]) < 0.05
    assert record.contact_force is not None
    seat = [not site.side and site.part == CHAIR_PART for site in record.sites]
    load = record.contact_force[:, seat, 2].sum(axis=1) / record.weight
    assert load[(time > 0.2) & (time < 0.6)].mean() > 0.6 and load[time > 2.8].mean() > 0.5
    assert load[(time > 1.2) & (time < 1.8)].max() == 0.0
