"""Shapes for an OpenSim model, whose meshes are files of their own: solids to draw, and soles."""

import re
from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.io.osim import OsimModel
from plantigrade.io.osim_tree import OsimLink
from plantigrade.models.parts import SoleSphere, Solid
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD as W

DENSITY = 1000.0  # [kg/m³] of a drawn capsule, near that of a body
RADII = (0.012, 0.11)  # [m] thinnest and thickest capsule
MIN_LENGTH = 0.015  # [m] of a drawn capsule
_FOOT = re.compile(r"(calcn|calcaneus|foot|hindfoot)_[rl]")
_TOES = re.compile(r"(toes|forefoot|phalanges)_[rl]")
SOLE_RADIUS = 0.01  # [m] of the spheres that tell where the sole is
HEEL_SHARE = 0.3  # [1] ankle to heel, relative to ankle to ball
HALF_WIDTH = 0.04  # [m] of the ball of the foot
HEEL_TO_BALL = 0.18  # [m] heel to toe joint, where there is none
BALL_TO_TIP = 0.065  # [m] toe joint to tip of the toes


def solids_of(model: OsimModel, links: Sequence[OsimLink]) -> dict[str, tuple[Solid, ...]]:
    """Return capsules to draw, by body: to the joints below it, or through its centre of mass."""
    ends: dict[str, list[np.ndarray]] = {link.name: [] for link in links}
    for link in links[1:]:
        ends[link.parent].append(link.position + link.rotation @ link.anchor)
    drawn = {}
    for link in links:
        segment, capsules = model.segments[link.name], []
        com = W @ segment.com
        tips = ends[link.name] or [link.anchor + 2 * (com - link.anchor)]
        if len(ends[link.name]) > 1 and com[2] > 0.1:  # a trunk, with the head on it
            tips.append(np.array([com[0], 0.0, 2 * com[2]]))
        for tip in tips:
            length = float(np.linalg.norm(tip - link.anchor))
            if length > MIN_LENGTH:
                radius = np.sqrt(segment.mass / len(tips) / (DENSITY * np.pi * length))
                radius = float(np.clip(radius, RADII[0], min(RADII[1], 0.5 * length)))
                capsules.append(Solid("capsule", link.anchor.copy(), tip, radius))
        drawn[link.name] = tuple(capsules)
    return drawn


def foot_bodies(links: Sequence[OsimLink]) -> dict[str, str]:
    """Return the body of each foot by side; empty where the names tell none."""
    return {link.name[-1]: link.name for link in links if _FOOT.fullmatch(link.name)}


def foot_spheres(links: Sequence[OsimLink]) -> dict[str, tuple[SoleSphere, ...]]:
    """Return the spheres of the soles by body.

    The origin of the calcaneus is the back of the heel in OpenSim's models; the ball of the foot is
    at the joint of the toes.
    """
    feet = foot_bodies(links)
    found: dict[str, tuple[SoleSphere, ...]] = {}
    for side, foot in feet.items():
        outward = -1.0 if side == "r" else 1.0
        toes = next((k for k in links if k.parent == foot and _TOES.fullmatch(k.name)), None)
        ball = np.array([HEEL_TO_BALL, 0.0, 0.0]) if toes is None else toes.position + toes.anchor
        heel = np.zeros(3)
        if not foot.startswith("calc"):  # its origin is the ankle
            heel = np.array([-HEEL_SHARE * ball[0], 0.0, ball[2]])
        rows = [(foot, "heel_back", heel)]
        rows += [(foot, f"metatarsal_{n}", ball + [0.0, y, 0.0]) for n, y in _width(outward)]
        tip = (
            (foot, ball + [BALL_TO_TIP, 0.0, 0.0])
            if toes is None
            else (toes.name, np.array([BALL_TO_TIP, 0, 0]))
        )
        rows += [(tip[0], f"toe_{n}", tip[1] + [0.0, y, 0.0]) for n, y in _width(outward)]
        for body, name, place in rows:
            at: Float[Array, " 3"] = np.asarray(place, dtype=float)
            sphere = SoleSphere(name, at, SOLE_RADIUS, body[:-2])
            found[body] = (*found.get(body, ()), sphere)
    return found


def _width(outward: float) -> tuple[tuple[int, float], ...]:
    """Return number and lateral place [m] of the first and the fifth ray."""
    return ((1, -outward * HALF_WIDTH), (5, outward * HALF_WIDTH))
