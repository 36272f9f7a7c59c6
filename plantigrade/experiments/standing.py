"""Who stands, how, and what keeps them standing: shared by the experiments on standing.

The body is the paper's [Park2020]_: 1.50 m, 48.5 kg, 66 degrees of freedom, 24 of them in its
multi-segment feet. Its other feet have the same length, width and mass and touch the ground at the
same sixteen points (``full_sole``), so that only joints differ. One stance, one set of weights and
one rate of the physics serve all feet.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control import Balance, Hybrid, Posture
from plantigrade.control.balance import Held
from plantigrade.models import FEET, Human
from plantigrade.world import Controller, Disturbance, World, standing_on
from plantigrade.world.grounds import ground_named

HEIGHT, MASS, SEX, JOINTS = 1.50, 48.5, "female", "66"  # the paper does not say the sex
RATE = 900.0
"""Steps of the physics [1/s]; at the paper's 1800 limits are the same within a step of the grid."""
AHEAD, WIDTH = 0.55, 0.147
"""Stance: centre of mass over the soles, from the heels; ankles apart, of the height: shoulders."""
ARMS = np.deg2rad(17.0)
"""How far the arms are from the trunk, so that they do not strike it [rad]."""
ROOMS = ("models", "wbc", "world", "control")
"""Rooms whose code decides how people stand."""
ORDER = ("multi-segment", "two-segment", "rigid")
assert set(ORDER) == set(FEET)


@dataclass(frozen=True)
class Formulation:
    """A way to keep balance.

    Attributes:
        words: What it is.
        rate: Commands per second [1/s].
        make: Makes a new controller of a person and a stance.
    """

    words: str
    rate: float
    make: Callable[[Human, Float[Array, " nq"]], Controller]


FORMULATIONS: dict[str, Formulation] = {
    "torque": Formulation(
        "torques within the strength of the joints and forces within friction cones, one program",
        90.0,
        lambda human, stance: Balance(Held(human, stance)),
    ),
    "hybrid": Formulation(
        "the paper's: accelerations by least squares, hybrid dynamics, no torque limits",
        30.0,
        lambda human, stance: Hybrid(Held(human, stance)),
    ),
    "posture": Formulation(
        "springs and dampers at the joints alone, within the strength of the joints",
        90.0,
        lambda human, stance: Posture(qpos=stance),
    ),
}


@dataclass(frozen=True)
class Standing:
    """A person who stands: called with disturbances it is a situation of a push test.

    Attributes:
        feet: Kind of feet.
        formulation: What keeps the balance, of :data:`FORMULATIONS`.
        ground: Name of the ground (:func:`~plantigrade.world.grounds.ground_named`).
        ahead: Place of the centre of mass over the soles, from the heels.
        width: Distance of the ankles, of the height.
        height: Stature [m].
        mass: Body mass [kg].
        seed: Of random ground.
        recording: Whether frames are kept.
    """

    feet: str = "multi-segment"
    formulation: str = "hybrid"
    ground: str = "flat"
    ahead: float = AHEAD
    width: float = WIDTH
    height: float = HEIGHT
    mass: float = MASS
    seed: int = 0
    recording: bool = False

    def __call__(self, disturbances: Sequence[Disturbance] = ()) -> tuple[World, Controller]:
        """Return a world with the person in it, and their controller."""
        human = person(self.feet, self.height, self.mass)
        ground = ground_named(self.ground, seed=self.seed)
        how = FORMULATIONS[self.formulation]
        qpos = standing_on(human, ground, ahead=self.ahead, width=self.width * self.height)
        qpos[[7 + human.hinge(f"arm_add_{side}") for side in SIDES]] = -ARMS
        world = World(
            human,
            ground,
            disturbances,
            rate=RATE,
            control_rate=how.rate,
            recording=self.recording,
            qpos=qpos,
        )
        return world, how.make(human, qpos)


@cache
def person(feet: str, height: float = HEIGHT, mass: float = MASS) -> Human:
    """Return the person of these experiments."""
    return Human.create(height, mass, SEX, JOINTS, feet, full_sole=True)


def pressing(world: World) -> int:
    """Return how many bones press on the ground: spheres that carry more than 1 N."""
    return int(np.sum(np.linalg.norm(world.contact_force(), axis=1) > 1.0))
