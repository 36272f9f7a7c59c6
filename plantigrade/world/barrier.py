"""A bar across the path, low enough that a person must stoop to pass."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.scene import SceneObject
from plantigrade.models import Human
from plantigrade.world.disturbance import Disturbance, parse_numbers
from plantigrade.world.simulated_world import SimulatedWorld
from plantigrade.world.world_model import LIMB_BIT

BAR_RADIUS = 0.02  # [m]
BAR_HALF_LENGTH = 1.5  # [m]
MEASURED_DISTANCE = 1.0  # [m] from the centre of mass, within which clearance is measured
NAME = "barrier"


@dataclass(frozen=True, kw_only=True)
class Barrier(Disturbance):
    """A fixed bar across the x axis, which stops trunk, head and limbs.

    While the person is near it, the signal ``barrier.clearance`` is the distance between the bar
    and the body surface, feet and legs included [m].

    Attributes:
        ahead: Distance in front of the origin [m].
        height: Height of the underside above level ground [m].

    Raises:
        ParameterError: If a number is out of range.
    """

    interval = 0.01
    ahead: float
    height: float

    def __post_init__(self):
        number("ahead", self.ahead, 0.5, 1e3, "m", "a barrier")
        number("height", self.height, 0.3, 3.0, "m", "a barrier")

    @staticmethod
    def parse(word: str) -> "Barrier":
        """Return the barrier that a text describes: distance and height of its underside [m].

        Raises:
            ParameterError: If the text has another form.

        Example:
            >>> Barrier.parse("5,1.6").height
            1.6
        """
        ahead, height = parse_numbers(
            word, "barrier", "AHEAD_M,HEIGHT_M such as 5,1.6: 5 m ahead, 1.6 m high", 2
        )
        return Barrier(ahead=ahead, height=height)

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add the bar to the model."""
        number = sum(body.name.startswith(NAME) for body in spec.bodies)
        place = [self.ahead, 0.0, self.height + BAR_RADIUS]
        body = spec.worldbody.add_body(name=f"{NAME}_{number}", pos=place)
        body.add_geom(
            name=f"{NAME}_{number}",
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[BAR_RADIUS, 0.0, 0.0],
            fromto=[0.0, -BAR_HALF_LENGTH, 0.0, 0.0, BAR_HALF_LENGTH, 0.0],
            contype=2 | LIMB_BIT,
            conaffinity=2 | LIMB_BIT,
            rgba=[0.72, 0.60, 0.45, 1.0],
            friction=[0.3, 0.005, 0.0001],
        )

    def reset(self, world: SimulatedWorld) -> None:
        """Find the geoms of the bar and of the body surface."""
        own = [d for d in world.disturbances if isinstance(d, Barrier)]
        bar = world.model.geom(f"{NAME}_{next(i for i, d in enumerate(own) if d is self)}").id
        model, n = world.model, len(world.human.body_names)
        body = np.array(model.geom_bodyid)
        skin = (body > 0) & (body <= n) & (np.array(model.geom_contype) == 0)
        world.memory[self] = bar, np.flatnonzero(skin)

    def act(self, world: SimulatedWorld) -> None:
        """Record the clearance."""
        if abs(float(world.data.subtree_com[1, 0]) - self.ahead) < MEASURED_DISTANCE:
            world.record_signal("barrier.clearance", clearance(world, *world.memory[self]))

    @property
    def scene_object(self) -> SceneObject:
        """The bar."""
        return SceneObject(NAME, "capsule", (BAR_RADIUS, BAR_HALF_LENGTH, 0.0))

    def pose(self, world: SimulatedWorld) -> Float[Array, " 7"]:
        """Return the pose of the bar, which lies across the path."""
        half = np.sqrt(0.5)
        return np.array([self.ahead, 0.0, self.height + BAR_RADIUS, half, half, 0.0, 0.0])


def clearance(world: SimulatedWorld, bar: int, skin: Array) -> float:
    """Return the distance between bar and body surface, negative if they overlap [m]."""
    ends = np.zeros(6)
    return min(
        mujoco.mj_geomDistance(world.model, world.data, bar, int(g), 2.0 * MEASURED_DISTANCE, ends)
        for g in skin
    )
