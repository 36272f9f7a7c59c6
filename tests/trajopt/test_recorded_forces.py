"""Forces, moments and seats that a tracked motion takes from the estimate of its recording."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.limb_sites import seat_sites
from plantigrade.contact.plan import ContactPlan, Footprint, PointSupport, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.ground_forces import GroundForces
from plantigrade.dynamics.loading import SEAT
from plantigrade.dynamics.plates import FootForces
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.trajopt import ContactBody
from plantigrade.trajopt.problem.contact import hold_contacts, site_places, site_targets
from plantigrade.trajopt.tasks.chair import seated_posture
from plantigrade.trajopt.tasks.recorded_forces import (
    HALF_WIDTH_90,
    expected_wrenches,
    forces_at_sites,
)
from plantigrade.trajopt.tasks.recorded_seat import supports_of
from plantigrade.trajopt.terms.tracking import FootWrenches

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def human():
    """A person of the joint set recordings are fitted with."""
    return Human.create(1.75, 70.0, joints="42")


def recorded(human: Human, load: float) -> GroundForces:
    """Return forces of three frames: the right foot is loaded in the first two, the left is not."""
    n, nv = 3, human.model.nv
    force, point = np.zeros((n, 2, 3)), np.full((n, 2, 3), np.nan)
    force[:2, 0, 2] = load
    point[:2, 0] = [[0.1, -0.1, 0.0], [0.2, -0.1, 0.0]]
    sure = np.ones((n, 2), bool)
    return GroundForces(
        FootForces(force, point, np.zeros((n, 2, 3)), sure, sure.all(axis=1)),
        measured=~sure,
        force_band=np.full((n, 2, 3), 30.0),
        point_band=np.full((n, 2, 2), 0.02),
        torque_band=np.full((n, 2), np.nan),
        moment_band=np.full((n, nv), 5.0),
        com_shift=np.zeros(3),
        noise=1.0,
        residual_force=0.0,
        residual_moment=0.0,
        contacts=(),
        supports=(),
        support_force=np.zeros((n, 0, 3)),
        support_point=np.zeros((n, 0, 3)),
        support_torque=np.zeros((n, 0, 3)),
    )


def test_bands_become_standard_errors(human):
    weight = human.mass * 9.81
    found = expected_wrenches(human, recorded(human, 350.0), np.array([0.0, 0.1, 0.2]))
    np.testing.assert_allclose(found.force[:2, 0, 2], 350.0 / weight, rtol=1e-3)
    np.testing.assert_allclose(found.force_error, 30.0 / weight / HALF_WIDTH_90, rtol=1e-3)
    np.testing.assert_allclose(found.point_error[:2, 0], 0.02 / HALF_WIDTH_90)
    assert np.isinf(found.point_error[2]).all()  # no load, no centre
    assert np.isinf(found.torque_error).all()  # no band, no weight
    np.testing.assert_allclose(found.point[2, 0], found.point[1, 0])
    between = found.at(np.array([0.05, 0.15]))
    np.testing.assert_allclose(between.point[0, 0], [0.15, -0.1])
    assert between.point_error[1, 0, 0] > 1.9 * found.point_error[0, 0, 0]
    assert between.torque_error.min() > 1e6


def test_sites_share_a_wrench(human):
    """Loads push, sum up, and have the centre of pressure where it is recorded."""
    body = ContactBody(human, foot_sites(human))
    q = human.to_coordinates(human.standing()[None])[1]
    carrying = np.array([[s.side == "r" for s in body.sites]])
    places = np.array(body.symbolic.positions(list(body.sites))(q[0]))
    own = [k for k, s in enumerate(body.sites) if s.side == "r"]
    middle = places[:2, own].mean(axis=1)
    zero = np.zeros((1, 2))
    feet = FootWrenches(
        np.zeros(1),
        np.array([[[0.1, 0.02, 0.9], [0.0, 0.0, 0.0]]]),
        np.array([[middle, middle]]),
        zero,
        np.ones((1, 2, 3)),
        np.ones((1, 2, 2)),
        np.ones((1, 2)),
    )
    u = forces_at_sites(body, feet, np.zeros((1, 3)), q, carrying).reshape(-1, 3)
    assert u[:, 2].min() >= 0 and not u[[k for k in range(len(u)) if k not in own]].any()
    np.testing.assert_allclose(u.sum(axis=0), [0.1, 0.02, 0.9], atol=0.02)
    np.testing.assert_allclose(places[:2] @ u[:, 2] / u[:, 2].sum(), middle, atol=0.01)


def test_a_site_lower_than_the_others_need_not_jump_when_it_leaves(human):
    """A sole of one's own is flat to a millimetre; its lowest site may rise from where it stood."""
    own = human.with_soles({"contact_foot_metatarsal_5_r": -0.002})
    body = ContactBody(own, foot_sites(own))
    footprint = Footprint("r", (0.0, 0.0, 0.0))
    plan = ContactPlan(1.0, (Stance(footprint, -1.0, -1.0, 0.4, 0.6, 0.8),))
    nodes = np.arange(0.0, 1.01, 0.1)
    angle = np.zeros((len(nodes), len(body.sites)))
    place, speed = (site_places(body, angle, rates=rates) for rates in (False, True))
    hold_contacts(body, plan, nodes, place, speed)
    k = next(k for k, s in enumerate(body.sites) if s.name == "metatarsal_5_r")
    flat = site_targets(body, footprint)["metatarsal_5_r"][2]
    assert flat < -3e-4  # it is the lowest one [m]
    np.testing.assert_allclose(place.lower[nodes > 0.45, 3 * k + 2], flat)


def test_a_person_is_held_on_one_chair_at_every_sit(human):
    """Two sits, a centimetre apart in height and three in place: one level, two places."""
    q = np.tile(seated_posture(human, 0.45), (101, 1))
    time = np.linspace(0.0, 2.0, 101)
    q[:, 4] += np.interp(time, [0.6, 0.8, 1.2, 1.4], [0.0, 0.3, 0.3, 0.006])
    q[time > 1.0, 3] += 0.03
    qpos = human.from_coordinates(human.to_coordinates(human.standing()[None])[0], q)
    still = np.zeros((101, human.model.nv))
    motion = Motion(time, qpos, still, human.joint_names, still)
    sits = (
        ContactInterval("", SEAT, 0.0, 0.62, begins=False),
        ContactInterval("", SEAT, 1.38, 2.0, ends=False),
    )
    found = supports_of(human, motion, sits, 0.0, 2.0)
    assert len(found) == 4 and {s.site.name for s in found} == {"seat_r", "seat_l"}
    assert len({s.position[2] for s in found}) == 1
    assert found[0].position[2] == pytest.approx(0.453, abs=0.006)
    assert found[2].position[0] - found[0].position[0] == pytest.approx(0.03, abs=1e-3)
    assert found[0].start < 0.0 and found[0].stop == pytest.approx(0.6, abs=0.03)
    assert found[2].start == pytest.approx(1.4, abs=0.03) and found[2].stop > 2.0
    assert supports_of(human, motion, (), 0.0, 2.0) == ()


def test_sites_of_a_seat_are_held_at_each_place(human):
    """The same site rests in one place, and later in another."""
    site = seat_sites(human)[0]
    places = ((-0.3, -0.06, 0.45), (-0.2, -0.06, 0.45))
    supports = (PointSupport(site, places[0], -1.0, 0.3), PointSupport(site, places[1], 0.7, 2.0))
    plan = ContactPlan(1.0, (), supports=supports)
    body = ContactBody(human, (site,))
    nodes = np.arange(0.0, 1.01, 0.1)
    angle = np.zeros((len(nodes), 1))
    place, speed = (site_places(body, angle, rates=rates) for rates in (False, True))
    hold_contacts(body, plan, nodes, place, speed)
    np.testing.assert_allclose(place.lower[1], places[0])
    np.testing.assert_allclose(place.lower[-2], places[1])
    assert not np.isfinite(place.lower[5]).any()


def test_replaced_forces_are_another_estimate(human):
    """Where a force is not recorded, it has no weight."""
    found = recorded(human, 350.0)
    unknown = replace(found.forces, valid_side=np.zeros((3, 2), bool))
    wrenches = expected_wrenches(human, replace(found, forces=unknown), np.arange(3.0))
    assert np.isinf(wrenches.force_error).all() and not wrenches.force.any()
