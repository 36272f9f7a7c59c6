"""What balance is made of, and how much each part of it counts."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human

FOOT = ("mtp", "cuboid", "heel")
"""What the names of the joints within a foot begin with."""

_USED: Mapping[str, float] = MappingProxyType(
    {"lumbar": 0.2, "thorax": 0.2, "arm": 0.05, "elbow": 0.05, "clavicle": 0.05, "hip": 0.3}
)


@dataclass(frozen=True, kw_only=True)
class Weights:
    r"""Costs of squared errors of acceleration, and the gains that say what is wanted.

    One set serves all experiments of one kind. The weights are those of the "hip" setting of a
    study of pushes: the centre of mass counts a thousand times a joint, so that trunk and arms
    give way where the centre of pressure has come to the edge of the support.

    Attributes:
        com: Of the centre of mass [per (m/s²)²].
        central: How far the centre of mass is to be on the way from where the reference has it to
            the middle of the points that press; none of it leaves less room to the heels than to
            the toes, for people stand with their weight behind the middle.
        com_gain: Stiffness of its way back [1/s²].
        com_damping: Its damping [1/s].
        momentum: Of the rate of the angular momentum, over body mass [per (m²/s²)²].
        momentum_damping: How fast it is to vanish [1/s].
        root: Of the orientation of the pelvis [per (rad/s²)²].
        tracking: Of a joint [per (rad/s²)²].
        used: Name a joint begins with → its part of ``tracking``: what keeps balance moves.
        foot: The same of the joints within a foot; small, it takes the shape of the ground.
        gain: Stiffness of joints and pelvis [1/s²]; critically damped, as is the next.
        foot_gain: The same within a foot [1/s²].
        contact: Of points that are to stay where they are [per (m/s²)²].
        contact_gain: Stiffness with which they do [1/s²].
        level: Of points that are to come to the ground (Eq. 7 of [Park2020]_, whose segments are
            level when their points touch) [per (m/s²)²].
        level_gain: :math:`k_s` of that equation [1/s²]. (With its 28, and little weight, points
            that have left the ground in a sideways push come back too late.)
        force: Of contact forces, a tenth of body weight along an edge.
        unasked: The same of points that touch and are not to press.
        friction: Part of the friction of the ground that is counted on.
    """

    com: float = 1000.0
    central: float = 0.25
    com_gain: float = 50.0
    com_damping: float = 14.0
    momentum: float = 1e-3
    momentum_damping: float = 2.0
    root: float = 0.1
    tracking: float = 1.0
    used: Mapping[str, float] = field(default_factory=lambda: _USED)
    foot: float = 1.0
    gain: float = 80.0
    foot_gain: float = 200.0
    contact: float = 1000.0
    contact_gain: float = 100.0
    level: float = 50.0
    level_gain: float = 200.0
    force: float = 1e-3
    unasked: float = 100.0
    friction: float = 0.8

    def joints(self, human: Human) -> Float[Array, " nv"]:
        """Return the weight of every coordinate; nothing for where the root is."""
        own = [self.tracking * self._part(name) for name in human.coordinates]
        return np.array([0.0] * 3 + [self.root] * 3 + own)

    def gains(self, human: Human) -> Float[Array, " nv"]:
        """Return the stiffness of every coordinate [1/s²]."""
        within = [n.startswith(FOOT) for n in human.coordinates]
        own = [self.foot_gain if inside else self.gain for inside in within]
        return np.array([0.0] * 3 + [self.gain] * 3 + own)

    def _part(self, name: str) -> float:
        if name.startswith(FOOT):
            return self.foot
        return next((part for start, part in self.used.items() if name.startswith(start)), 1.0)
