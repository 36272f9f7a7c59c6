"""What is known of contacts before ground forces are computed: frames, usual paths and shares."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.force_rows import PathPrior
from plantigrade.dynamics.force_scales import LEAN, PHASE, ForceScales
from plantigrade.dynamics.loading import Support, usual_length
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.required_forces import MIN_LEVEL_DIFFERENCE, RequiredForces

MAX_CONTACT_LEAN = -0.15
"""Largest median forward lean of shanks at heel strike with which they show the path [rad]. Walks
of seven people with markers have -0.37 to -0.21, 16 walks in skeleton files -0.24 to 0.30."""
FLAT_FOOT_COP = (0.02, 0.009)  # lateral position for a flat foot [foot lengths] and its SD [m]
# [m] standard deviation of the centre of pressure on a seat, forward and lateral
SEAT_COP_SPREAD = (0.04, 0.035)


def lasting(contact: ContactInterval, more: float) -> ContactInterval:
    """Return a contact, extended by ``more`` [s] beyond an end of the recording that cuts it."""
    start = contact.start if contact.begins else contact.start - more
    return replace(contact, start=start, stop=contact.stop if contact.ends else contact.stop + more)


def contact_frames(
    needs: RequiredForces,
    contacts: tuple[ContactInterval, ...],
    supports: tuple[Support, ...],
    scales: ForceScales,
    length: float,
) -> tuple[Bool[Array, "n k"], Float[Array, "n k"], PathPrior]:
    """Return contact frames, maximum loads [BW], and where pressure and load usually are.

    Columns are the right and the left foot, then the supports.

    Args:
        needs: What the motion requires.
        contacts: When feet and supports bear the person.
        supports: What bears the person besides the feet.
        scales: Scales of the program.
        length: Length of the foot [m].
    """
    time = needs.time
    names = (*SIDES, *(support.name for support in supports))
    n, m = len(time), len(names)
    contact, ramp = np.zeros((n, m), bool), np.full((n, m), np.inf)
    mean, spread = np.full((n, m, 2), np.nan), np.ones((n, m, 2))
    side, forward = np.full((n, m), np.nan), np.zeros((n, m, 2))
    usual, curves = usual_length(contacts), scales.usual
    over_time = scales.pace > 1.0 or not _leans_back(needs, contacts)
    for each in contacts:
        k, here = names.index(each.side or each.region), each.frames(time)
        contact[here, k] = True
        t, limit = time[here], np.full(int(here.sum()), np.inf)
        if each.begins:
            limit = np.minimum(limit, t - each.start)
        if each.ends:
            limit = np.minimum(limit, each.stop - t)
        ramp[here, k] = 0.01 + scales.loading * limit
        if not each.side:
            ramp[here, k] = np.inf
            mean[here, k], spread[here, k] = 0.0, np.array(SEAT_COP_SPREAD)
            continue
        outward = -1.0 if each.side == "r" else 1.0
        mean[here, k, 1], spread[here, k, 1] = outward * length * FLAT_FOOT_COP[0], FLAT_FOOT_COP[1]
        if each.rolls and len(t):
            s, lean = each.share(t, usual), needs.lean[here, k]
            if over_time:
                mean[here, k, 0] = length * np.interp(s, PHASE, curves.cop_forward)
                spread[here, k, 0] = np.interp(s, *curves.cop_forward_spread)
            else:
                mean[here, k, 0] = length * np.interp(lean, LEAN, curves.roll_over)
                spread[here, k, 0] = np.interp(lean, *curves.roll_over_spread)
            if scales.pace > 1.0:  # runners land on the heel like walkers but step in one line
                continue
            mean[here, k, 1] = outward * length * np.interp(s, PHASE, curves.cop_outward)
            spread[here, k, 1] = np.interp(s, *curves.cop_outward_spread)
            side[here, k] = -outward * np.interp(s, PHASE, curves.force_inward)
            ahead = needs.rotation[here, :2, 0].mean(axis=0)
            forward[here, k] = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    share = _usual_shares(needs, contacts, scales)
    return contact, ramp, PathPrior(mean, spread, side, forward, share)


def _leans_back(needs: RequiredForces, contacts: tuple[ContactInterval, ...]) -> bool:
    """Return whether shanks lean back at heel strike as people's do, so that they show the path.

    Knees that are bent there are mostly those of a skeleton file, whose shanks lean too far forward
    all through the stance.
    """
    leans = [
        needs.lean[np.searchsorted(needs.time, each.start), SIDES.index(each.side)]
        for each in contacts
        if each.rolls and each.begins and needs.time[0] <= each.start < needs.time[-1]
    ]
    return not leans or bool(np.median(leans) < MAX_CONTACT_LEAN)


def _usual_shares(
    needs: RequiredForces, contacts: tuple[ContactInterval, ...], scales: ForceScales
) -> np.ndarray:
    """Return the usual shares of both feet in the load of double supports of a walk (n, 2).

    They are unknown in running and in a recording with steps.
    """
    time, found = needs.time, np.full((len(needs.time), 2), np.nan)
    level = bool(np.ptp(needs.base[:, :2, 2]) < MIN_LEVEL_DIFFERENCE)
    steps = [c for c in contacts if c.rolls and level and scales.pace == 1.0]
    for rear in steps:
        for front in steps:
            if rear.side == front.side or not (front.begins and rear.ends):
                continue
            if not rear.start < front.start < rear.stop < front.stop:
                continue
            phase = (time - front.start) / (rear.stop - front.start)
            here = (phase >= 0.0) & (phase <= 1.0)
            share = np.interp(phase[here], PHASE, scales.usual.rear_share)
            found[here, SIDES.index(rear.side)] = share
            found[here, SIDES.index(front.side)] = 1.0 - share
    return found


def measured_wrenches(
    data: FootForces, needs: RequiredForces
) -> tuple[Bool[Array, "n 2"], Float[Array, "n 2 6"], Bool[Array, "n 2"]]:
    """Return whether the wrench of each foot is measured, the wrench, and whether it bears load.

    The wrench is force [BW] and moment about the base of the foot [BW m], zero without load.
    """
    known = np.array(data.valid_side)
    force = data.force / needs.weight
    carried = np.isfinite(data.point).all(axis=-1) & (force[..., 2] > 0)
    arm = np.where(carried[..., None], data.point - needs.base[:, :2], 0.0)
    moment = np.cross(arm, force) + data.torque / needs.weight
    measured = np.concatenate([force, moment], axis=-1)
    return known, np.where(carried[..., None], measured, 0.0), carried
