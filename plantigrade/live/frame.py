"""What is seen of a session at one instant, and its last seconds."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.scene_object import SceneObject
from plantigrade.world import Drawing, World

SPAN = 5.0
"""So many seconds are kept for curves."""
LOADED = 0.02
"""A foot that carries less has no centre of pressure [body weights]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame:
    """Everything that is drawn, as copies: the session goes on meanwhile.

    Attributes:
        world: Whose it is; another one has other bodies.
        time: Since the start [s].
        positions: Of the bodies of the world's model [m].
        quats: Their rotations, ``wxyz``.
        com: Centre of mass [m].
        force: Of the ground at each contact sphere, world [N].
        point: Where it acts [m].
        rope: From where a body is held to the hand [m]; None where none is.
        pushes: Where something pushes [m], and its force [N].
        pack: What is on the back, half its sizes [m]; None where nothing is.
        worn: Middle of the trunk's back [m] and rotation ``wxyz``: where a pack is.
        drawings: Of the controller.
        past: The last seconds.
        ended: Why it does not go on as it should; empty while it does.
    """

    world: World
    time: float
    positions: Float[Array, "nbody 3"]
    quats: Float[Array, "nbody 4"]
    com: Float[Array, " 3"]
    force: Float[Array, "n_sites 3"]
    point: Float[Array, "n_sites 3"]
    rope: Float[Array, "2 3"] | None
    pushes: Float[Array, "n 2 3"]
    pack: SceneObject | None
    worn: Float[Array, " 7"]
    drawings: tuple[Drawing, ...]
    past: "Past"
    ended: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Past:
    """The last seconds of a session, one row for each control step.

    Attributes:
        time: When [s].
        angles: Of the hinges [rad].
        torques: Of their motors [N m].
        vertical: Force of the ground on the right and the left foot [N].
        cop: Centre of pressure of both together, over the ground [m]; NaN in the air.
    """

    time: Float[Array, " n"]
    angles: Float[Array, "n n_hinges"]
    torques: Float[Array, "n n_hinges"]
    vertical: Float[Array, "n 2"]
    cop: Float[Array, "n 2"]


class History:
    """Keeps the last seconds of a world."""

    def __init__(self, world: World):
        self._n = 0
        self._rows = max(2, round(SPAN * world.control_rate))
        hinges = len(world.human.coordinates)
        sizes = {"time": (), "angles": (hinges,), "torques": (hinges,)}
        sizes |= {"vertical": (2,), "cop": (2,)}
        self._kept = {name: np.zeros((2 * self._rows, *size)) for name, size in sizes.items()}
        self._feet = np.array([[s.side == side for s in world.sites] for side in SIDES], float)

    def keep(
        self, world: World, force: Float[Array, "n_sites 3"], point: Float[Array, "n_sites 3"]
    ) -> None:
        """Keep the present step."""
        up = np.maximum(force[:, 2], 0.0)
        load = float(up.sum())
        loaded = load > LOADED * world.human.mass * float(-world.model.opt.gravity[2])
        if self._n == 2 * self._rows:  # the newer half moves to the front
            for values in self._kept.values():
                values[: self._rows] = values[self._rows :]
            self._n = self._rows
        row = {
            "time": world.time,
            "angles": world.data.qpos[7 : world.human.model.nq],
            "torques": world.actuators.motor_torques(world.data),
            "vertical": self._feet @ force[:, 2],
            "cop": up @ point[:, :2] / load if loaded else np.full(2, np.nan),
        }
        for name, value in row.items():
            self._kept[name][self._n] = value
        self._n += 1

    def past(self) -> Past:
        """Return a copy of what is kept."""
        first = max(0, self._n - self._rows)
        return Past(**{name: values[first : self._n].copy() for name, values in self._kept.items()})
