"""Contact sites of limbs, seat, back and head on a floor, a chair, a wall or a rail."""

from dataclasses import replace

import numpy as np

from plantigrade.bounds import word
from plantigrade.constants import SIDES
from plantigrade.contact.site import CHAIR_PART, ContactSite, Point, foot_sites
from plantigrade.models import Human

REFERENCE_HEIGHT = 1.75  # [m] stature of the person whom the following length belongs to
PALM = 0.08  # [m] middle of the palm below the wrist
HAND_PART = "hand"  #: Part name of a site that rests on an armrest, a wall or a rail
KNEE_PART = "knee"  #: Part name of a site that kneels
KNEELING_PITCH = float(np.pi / 2)
"""Forward pitch of a shank that lies on the ground [rad]; its knee rolls from there."""
TOES_PART = "toes"  #: Part name of the ball of a foot that kneels on its toes
HEEL_PART = "heel_behind"  #: Part name of the back of a heel, on which a stretched leg lies
BUTTOCK_PART = "buttock"  #: Part name of a buttock, on which the pelvis rolls from lying to sitting
BACK_PART = "back"  #: Part name of half of the upper back
HEAD_PART = "head"  #: Part name of the back of the head
LYING_PITCHES = {
    KNEE_PART: KNEELING_PITCH,
    **dict.fromkeys((HEEL_PART, BUTTOCK_PART, BACK_PART, HEAD_PART), -KNEELING_PITCH),
}
"""Forward pitch of a body from which its site rolls, by part [rad]; zero for the others."""
BALL = "metatarsal_1"
"""Sphere on which kneeling toes rest; the axis of the knee turns the shank so that it is lowest."""
SUPPORTED_PARTS = (
    *(
        f"{part}_{side}"
        for part in (HAND_PART, KNEE_PART, "seat", TOES_PART, HEEL_PART, BUTTOCK_PART, BACK_PART)
        for side in SIDES
    ),
    HEAD_PART,
)
"""Parts of the body that a support of a task may carry, besides feet."""
SEATED_PELVIS_TILT = float(np.deg2rad(15.0))
"""Posterior tilt of the pelvis in upright sitting [rad]. Estimate."""
HIP_ABOVE_SEAT = 0.055
"""Height of the hip joint above the seat, relative to stature [1]; 10 cm. Estimate."""
ISCHIAL_DISTANCE = 0.068
"""Distance between the ischial contacts, relative to stature [1]; 12 cm. Estimate."""
BACK_ASIDE = 0.5  # [1] contact of half of the back from the middle, of half the chest's width
ISCHIAL_RADIUS = 0.025  # Radius of an ischial contact sphere, relative to stature [1]. Estimate.
REAR_DISTANCE = 0.04
"""How far behind the ischia the buttocks bear on a cushion, relative to stature [1]; 7 cm.

Estimate, by which recorded people rise, as with 5 and 9 cm. The centre of pressure of a person who
leans back is 6 cm behind the ischia; with nothing there, the trunk cannot be thrown forward.
"""


def palm(human: Human, side: str) -> Point:
    """Return the middle of the palm."""
    body, origin = human.skeleton.parts[f"hand_{side}"]
    return Point(body, origin + np.array([0.0, 0.0, -PALM * human.height / REFERENCE_HEIGHT]))


def limb_site(human: Human, part: str, *, on_ground: bool = False) -> ContactSite:
    """Return the contact site of a part of the body other than a sole.

    A hand rests on the middle of the palm, a point, which on the ground is as far from the bones as
    the surface of the wrist. A knee rests on a sphere about the joint as thick as the thigh, which
    the shank turns; toes of a leg that kneels roll on the ball of the foot, and a leg that is
    stretched on the ground lies on the outer edge of the back of the heel. On a buttock, a sphere
    about the hip joint, the pelvis rolls from lying to sitting. Upper back and back of the head are
    spheres, as curved as chest and head are.

    Raises:
        ParameterError: If the part is none of :data:`SUPPORTED_PARTS`.
    """
    word("part", part, SUPPORTED_PARTS)
    if part == HEAD_PART:
        return _on_back(human, "head", part, part)
    stem, side = part[:-2], part[-1]
    left = -1.0 if side == "r" else 1.0
    if stem == BACK_PART:
        return _on_back(human, human.trunk, part, BACK_PART, left * BACK_ASIDE)
    if stem == BUTTOCK_PART:
        hip = human.model.body_pos[human.body(f"femur_{side}")]
        radius = HIP_ABOVE_SEAT * human.height
        return ContactSite(body="pelvis", position=hip, radius=radius, name=part, part=BUTTOCK_PART)
    if stem == "seat":
        return next(site for site in seat_sites(human) if site.name == part)
    if stem == TOES_PART:
        ball = next(s for s in foot_sites(human) if s.name == f"{BALL}_{side}")
        return replace(ball, side="", part=TOES_PART, name=part)
    if stem == HEEL_PART:
        heels = [s for s in foot_sites(human) if s.side == side and s.part == "heel"]
        heel = max(heels, key=lambda s: (-s.position[0], left * s.position[1]))
        return replace(heel, side="", part=HEEL_PART, name=part)
    if stem == KNEE_PART:
        thigh = next(b for b in human.skeleton.bodies if b.name == f"femur_{side}")
        radius = float(thigh.solids[0].radius)
        return ContactSite(body=f"tibia_{side}", radius=radius, name=part, part=KNEE_PART)
    point = palm(human, side)
    position = np.array(point.position)
    if on_ground:  # as thick as the wrist, which is above the ground then
        wrist = human.skeleton.parts[f"radius_{side}"][0]
        forearm = next(b for b in human.skeleton.bodies if b.name == wrist)
        position += [float(forearm.solids[-1].radius), 0.0, 0.0]
    return ContactSite(body=point.body, position=position, name=part, part=HAND_PART)


def _on_back(human: Human, body: str, name: str, part: str, aside: float = 0.0) -> ContactSite:
    """Return a sphere on the back of the highest ellipsoid of a body, which lies inside it.

    It has the curvature of the ellipsoid, in the sagittal plane, where the body lies level.

    Args:
        aside: How far to the left of the middle, of half the width of the ellipsoid.
    """
    solids = next(b.solids for b in human.skeleton.bodies if b.name == body)
    solid = max((s for s in solids if s.kind == "ellipsoid"), key=lambda s: float(s.a[2]))
    deep, wide, high = map(float, solid.b)
    radius = high**2 / deep
    position = solid.a + [radius - deep, aside * wide, 0.0]
    return ContactSite(body=body, position=position, radius=radius, name=name, part=part)


def seat_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the two ischial contact sites."""
    hip = human.model.body_pos[human.body("femur_r")]
    radius = ISCHIAL_RADIUS * human.height
    drop = HIP_ABOVE_SEAT * human.height - radius
    # vertically below the hip joints with the pelvis tilted as in sitting
    x = hip[0] - drop * np.sin(SEATED_PELVIS_TILT)
    z = hip[2] - drop * np.cos(SEATED_PELVIS_TILT)
    half = ISCHIAL_DISTANCE * human.height / 2
    return tuple(
        ContactSite(
            body="pelvis", position=(x, y, z), radius=radius, name=f"seat_{side}", part=CHAIR_PART
        )
        for side, y in (("r", -half), ("l", half))
    )


def cushioned_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the contact sites that a cushion carries: the ischia, and the buttocks behind them.

    They are level where the pelvis is tilted as in upright sitting.
    """
    ischia = seat_sites(human)
    c, s = np.cos(SEATED_PELVIS_TILT), np.sin(SEATED_PELVIS_TILT)
    behind = REAR_DISTANCE * human.height * np.array([-c, 0.0, s])
    rear = (
        replace(each, position=each.position + behind, name=each.name.replace("seat", "seat_rear"))
        for each in ischia
    )
    return (*ischia, *rear)
