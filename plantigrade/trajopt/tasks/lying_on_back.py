"""From lying on the back with stretched legs to sitting on the floor.

Palms lie beside the hips. Head and upper back leave the floor, arms push, and the pelvis rolls on
the buttocks until the person sits; the knees bend by as much as the hips come closer to the heels.
Palms and heels stay where they are. Eight of 52 healthy adults of 50 to 90 years rise over a
symmetrical sit-up; all take 4.1 (SD 1.1) s, whichever way they rise [Bohannon2004]_. Of twenty
adults of 65 years and more twelve sit up [Burton2023]_.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import (
    BACK_PART,
    BUTTOCK_PART,
    HEAD_PART,
    LYING_PITCHES,
    limb_site,
)
from plantigrade.contact.plan import PointSupport
from plantigrade.contact.site import Point
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.spatial.conventions import PELVIS
from plantigrade.trajopt.guess.lying_leg import LyingLeg
from plantigrade.trajopt.guess.postures import body_at, standing_posture, with_limbs
from plantigrade.trajopt.tasks.chair import resting_place

Coordinates = Float[Array, " nv"]


@dataclass(frozen=True)
class LyingOnBack:
    """How a person lies, and when contacts change. All are estimates."""

    head_off: float = 0.03  #: The head leaves the floor [1, of the duration]
    back_off: float = 0.06  #: The upper back leaves the floor [1]
    sits: float = 0.25  #: The person sits, and gets up from there in the time left [1]
    knee: float = float(np.deg2rad(8.0))  #: Flexion of the knees [rad]
    hands_behind: float = 0.1  #: Palms behind the hips in sitting [stature]
    hands_aside: float = 0.16  #: Palms from the middle [stature]


STRAIGHT = {"lumbar_extension": 40.0, "thorax_extension": 40.0, "neck_extension": 5.0}
"""Weights of angles of trunk and neck away from zero until the person sits [1/(s rad²)]. Chosen:
without them the lumbar spine extends by 40° and the upper trunk bends forward by as much, both held
by their passive tissue at no cost, and the chin is on the chest."""
ARMS_BESIDE = {
    "arm_flex": -0.37, "arm_add": -1.24, "arm_rot": 0.98, "elbow_flex": 1.7, "pro_sup": 1.83,
    "wrist_flex": 0.03,
}  # fmt: skip
"""Arms on the floor, palms beside the hips, to start from [rad]. Estimate."""
CURLED = {"pelvis_tilt": 1.2, "lumbar_extension": -0.5, "neck_extension": -0.3}
"""Pelvis, trunk and neck half the way up, to start from [rad]. Estimate."""


@dataclass(frozen=True)
class SittingUp:
    """The part of a motion before sitting."""

    reach: float  #: Heels ahead of the hips in sitting [m]
    keys: tuple[tuple[float, Coordinates], ...]  #: Times [s] and postures to start from
    supports: tuple[PointSupport, ...]  #: Supports of head and upper back


def sitting_up(
    human: Human, hip: float, tilt: float, duration: float, how: LyingOnBack
) -> SittingUp:
    """Return how a person sits up.

    Args:
        hip: Hips in sitting, along x [m].
        tilt: Posterior tilt of the pelvis then [rad].
        duration: Duration of the whole motion, of which the times of ``how`` are shares [s].
    """
    lain = lying_posture(human)
    buttock = limb_site(human, f"{BUTTOCK_PART}_r")
    leg = LyingLeg(human, buttock.radius)
    ahead = hip + buttock.radius * tilt  # where the hips would be with an upright pelvis
    behind = buttock.radius * (float(lain[0]) - tilt)
    reach = leg.reach(how.knee) - behind
    lain[3] += hip - behind
    lain = with_limbs(human, lain, dict.fromkeys(SIDES, leg.angles(how.knee, float(lain[0]))))
    turn = CURLED["pelvis_tilt"]
    rolled = ahead - buttock.radius * turn
    bent = leg.angles(leg.knee(hip + reach - rolled), turn)
    curled = with_limbs(human, lain, dict.fromkeys(SIDES, bent))
    for i, name in enumerate(PELVIS + human.coordinates):
        curled[i] = CURLED.get(name, curled[i])
    curled = _on_buttocks(human, curled, rolled)
    middle = (how.back_off + how.sits) / 2
    keys = ((0.0, lain), (how.back_off * duration, lain), (middle * duration, curled))
    leaves = dict.fromkeys((f"{BACK_PART}_{side}" for side in SIDES), how.back_off)
    leaves[HEAD_PART] = how.head_off
    supports = []
    for part, share in leaves.items():
        site = limb_site(human, part)
        pitch = LYING_PITCHES[site.part]
        x, y, _ = resting_place(human, site, lain, pitch)
        supports.append(PointSupport(site, (x, y, 0.0), -1.0, share * duration, pitch=pitch))
    return SittingUp(reach, keys, tuple(supports))


def lying_posture(human: Human) -> Coordinates:
    """Return the coordinates of a person on buttocks, upper back and head, with a straight trunk.

    The middle of the hip joints is at x = 0.
    """
    q = standing_posture(human)
    q[:3], q[6:] = 0.0, 0.0
    q = with_limbs(human, q, dict.fromkeys(SIDES, ARMS_BESIDE))
    buttock, back = (limb_site(human, f"{part}_r") for part in (BUTTOCK_PART, BACK_PART))
    q[0] = _turn(_places(human, q, (buttock, back)), buttock.radius, back.radius)
    q = _on_buttocks(human, q, 0.0)
    head = limb_site(human, HEAD_PART)
    joint_and_head = _places(human, q, (Point(head.body), head))
    q[6 + human.hinge("neck_extension")] = _turn(joint_and_head, joint_and_head[0][2], head.radius)
    return q


def _on_buttocks(human: Human, q: Coordinates, hip: float) -> Coordinates:
    """Return a posture whose hips are at a place along x, on the buttocks."""
    out, buttock = q.copy(), limb_site(human, f"{BUTTOCK_PART}_r")
    x, _, z = _places(human, out, (buttock,))[0]
    out[3:5] += hip - x, buttock.radius - z
    return out


def _places(human: Human, q: Coordinates, points: Sequence[Point]) -> Float[Array, "n 3"]:
    """Return where points are in a posture, world [m]."""
    return body_at(human, q).position(PointSet.of(human, points))


def _turn(places: Float[Array, "2 3"], low: float, high: float) -> float:
    """Return the turn backwards after which two points are at two heights [rad].

    Args:
        places: The points before it, world [m].
        low: Height of the first point [m].
        high: Height of the second [m].
    """
    x, _, z = places[1] - places[0]
    return float(np.arctan2(x, z) + np.arccos((high - low) / np.hypot(x, z)))
