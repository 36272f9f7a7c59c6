"""People who stand and the controllers of their balance, for the experiments on standing.

The body is the paper's [Park2020]_: 1.50 m, 48.5 kg, 66 degrees of freedom, 24 of them in its
multi-segment feet. Its other feet have the same length, width and mass and touch the ground at the
same sixteen points (``full_sole``), so that only joints differ. One stance, one set of weights and
one rate of the physics serve all feet.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from experiments.push_limits import on_feet
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import GEOM_PREFIX
from plantigrade.control import Posture
from plantigrade.control.balance import Balance, BalanceSettings, Hybrid, posture_reference
from plantigrade.control.balance.reference import PLATFORM
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.threads import on_one_thread
from plantigrade.world import Controller, Disturbance, World, standing_on
from plantigrade.world.grounds import ground_named

HEIGHT = 1.50
"""Stature of the person [m]."""
MASS = 48.5
"""Mass of the person [kg]."""
SEX = "female"
"""The paper does not say the sex."""
JOINTS = "66"
"""Joints of the person, as in the paper."""
RATE = 900.0
"""Rate of the physics [1/s]; the paper has 1800."""
COM_FROM_HEELS = 0.60
"""Position of the centre of mass over the soles, from the heels [sole lengths].

People have it at 0.45; the paper's 65 N from the front and 50 N from the back are those of a
pendulum at some 0.6.
"""
STANCE_WIDTH = 0.147
"""Distance of the ankles [statures]."""
ARM_ABDUCTION = np.deg2rad(17.0)
"""Angle of the arms from the trunk, without collisions [rad]."""
MAX_SPEED = 0.1
"""Greatest speed of a person at rest [m/s]."""
MAX_LEAN = np.deg2rad(40.0)
"""Greatest lean of a person at rest [rad]."""
PRESSING_FORCE = 1.0
"""Force above which a contact point presses [N]."""
SETTLING_TIME = 1.0
"""Time from which slip is measured [s]."""
FEET = ("multi-segment", "two-segment", "rigid")
PUSHES = {"front": np.pi, "side": np.pi / 2, "back": 0.0}
"""Where a push comes from, in the paper's words → its direction [rad]."""


@dataclass(frozen=True)
class Formulation:
    """A controller of balance.

    Attributes:
        rate: Command rate [1/s].
        make: Returns a new controller for a world and a stance.
    """

    rate: float
    make: Callable[[World, Float[Array, " nq"]], Controller]


FORMULATIONS: dict[str, Formulation] = {
    # torques within the strength of the joints and forces within friction cones, one program
    "torque": Formulation(
        90.0,
        lambda world, stance: Balance(posture_reference(world, stance)),
    ),
    # the same, and a step is taken where standing in place can no longer succeed
    "stepping": Formulation(
        90.0,
        lambda world, stance: Balance(
            posture_reference(world, stance), settings=BalanceSettings(stepping=True)
        ),
    ),
    # the paper's: accelerations by least squares, hybrid dynamics, no torque limits
    "hybrid": Formulation(
        30.0,
        lambda world, stance: Hybrid(posture_reference(world, stance)),
    ),
    # springs and dampers at the joints alone, within the strength of the joints
    "posture": Formulation(
        90.0,
        lambda world, stance: Posture(qpos=stance),
    ),
}


@dataclass(frozen=True)
class Standing:
    """A person who stands: called with disturbances it is a situation of a push test.

    Attributes:
        feet: Kind of feet.
        formulation: Controller of balance, of :data:`FORMULATIONS`.
        ground: Name of the ground (:func:`~plantigrade.world.grounds.ground_named`).
        ahead: Position of the centre of mass over the soles, from the heels.
        width: Distance of the ankles, of the height.
        height: Stature [m].
        mass: Body mass [kg].
        seed: Seed of random ground.
        recording: Whether frames are recorded.
        full_sole: Whether all feet have the same sixteen contacts. By default a two-segment and a
            rigid foot have seven of them.
    """

    feet: str = "multi-segment"
    formulation: str = "hybrid"
    ground: str = "flat"
    ahead: float = COM_FROM_HEELS
    width: float = STANCE_WIDTH
    height: float = HEIGHT
    mass: float = MASS
    seed: int = 0
    recording: bool = False
    full_sole: bool = True

    def __call__(self, disturbances: Sequence[Disturbance] = ()) -> tuple[World, Controller]:
        """Return a world with the person in it, and the controller."""
        human = person(self.feet, self.height, self.mass, self.full_sole)
        ground = ground_named(self.ground, seed=self.seed)
        how = FORMULATIONS[self.formulation]
        qpos = standing_on(human, ground, com_along_sole=self.ahead, width=self.width * self.height)
        qpos[[7 + human.hinge(f"arm_add_{side}") for side in SIDES]] = -ARM_ABDUCTION
        world = World(
            human,
            ground,
            disturbances,
            rate=RATE,
            control_rate=how.rate,
            recording=self.recording,
            qpos=qpos,
        )
        return world, how.make(world, qpos)


@cache
def person(feet: str, height: float = HEIGHT, mass: float = MASS, full_sole: bool = True) -> Human:
    """Return the person of these experiments."""
    return Human.create(height, mass, SEX, JOINTS, feet, full_sole=full_sole)


@on_one_thread
def stand(
    standing: Standing, disturbances: Sequence[Disturbance], duration: float
) -> dict[str, Any]:
    """Return the figures of a person who stands for a duration [s].

    ``stood``; ``time`` until a fall [s]; ``slip``, the longest path along the ground of a pressing
    contact point since the first second [mm]; ``points``, the mean number of pressing points in
    the second half; ``wobble``, the root mean square of the trunk's lean from its first attitude
    [deg], and ``sway``, that of the centre of mass over the ground [mm].
    """
    world, controller = standing(disturbances)
    state = world.reset()
    trunk = world.human.trunk
    geoms = [world.model.geom(GEOM_PREFIX + site.name).id for site in world.sites]
    plate = [i for i in range(world.model.nbody) if world.model.body(i).name == PLATFORM]
    first_up, first_com = state.body.rotation(trunk)[:, 2], state.body.com
    settled: np.ndarray | None = None
    slip, points, leans, sways = 0.0, [], [], []
    while world.time < duration - 0.5 / world.rate and on_feet(world):
        state = world.step(controller(state))
        pressing = np.linalg.norm(world.contact_force(), axis=1) > PRESSING_FORCE
        place = np.array(world.data.geom_xpos)[geoms]
        if plate:
            turn = world.data.xmat[plate[0]].reshape(3, 3)
            place = (place - world.data.xpos[plate[0]]) @ turn
        if world.time >= SETTLING_TIME and settled is None:
            settled = place.copy()
        if settled is not None and pressing.any():
            moved = np.linalg.norm((place - settled)[pressing, :2], axis=1)
            slip = max(slip, float(moved.max()))
        if world.time > duration / 2:
            points.append(int(pressing.sum()))
        up = state.body.rotation(trunk)[:, 2]
        leans.append(np.arccos(np.clip(up @ first_up, -1.0, 1.0)))
        sways.append(np.linalg.norm((state.body.com - first_com)[:2]))
    return {
        "stood": on_feet(world),
        "time": world.time,
        "slip": 1e3 * slip,
        "points": float(np.mean(points)) if points else None,
        "wobble": float(np.rad2deg(np.sqrt(np.mean(np.square(leans))))),
        "sway": float(1e3 * np.sqrt(np.mean(np.square(sways)))),
    }


def is_standing(world: World) -> bool:
    """Return whether a person is upright, at rest, and has the left foot on the left."""
    nq, nv = world.human.model.nq, world.human.model.nv
    body = BodyState(world.human, world.data.qpos[:nq], world.data.qvel[:nv])
    feet = [world.human.body(f"foot_{side}") for side in SIDES]
    apart = (body.origin(feet[1]) - body.origin(feet[0])) @ body.rotation(1)[:, 1]
    upright = body.rotation(world.human.trunk)[2, 2] > np.cos(MAX_LEAN)
    slow = np.linalg.norm(body.com_velocity) < MAX_SPEED
    return bool(upright and slow and apart > 0)


def summary(result: Mapping[str, Any]) -> str:
    """Return one line about a person."""
    if not result["stood"]:
        return f"fell at {result['time']:.2f} s"
    return f"stood, {result['points']:.0f} points, trunk {result['wobble']:.1f} deg"
