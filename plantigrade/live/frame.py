"""State of a session for display at one instant, and its recent history."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.scene import SceneObject
from plantigrade.world import Drawing, World

HISTORY_DURATION = 5.0  # [s] of the curves
MIN_LOAD = 0.02  # [body weights] on the feet; below it the centre of pressure is undefined


@dataclass(frozen=True, eq=False, kw_only=True)
class LiveFrame:
    """Everything that is drawn, copied because the session continues meanwhile."""

    world: World  #: The world; another world has other bodies
    time: float  #: Time since the start [s]
    positions: Float[Array, "nbody 3"]  #: Positions of the bodies of the world's model [m]
    quats: Float[Array, "nbody 4"]  #: Orientations of the bodies, ``wxyz``
    com: Float[Array, " 3"]  #: Centre of mass [m]
    force: Float[Array, "n_sites 3"]  #: Ground reaction force at each contact sphere, world [N]
    point: Float[Array, "n_sites 3"]  #: Points of application [m]
    #: End points of the rope, at the body and at the hand [m]; None without a rope
    rope: Float[Array, "2 3"] | None
    pushes: Float[Array, "n 2 3"]  #: Points of pushes [m], and their forces [N]
    pack: SceneObject | None  #: Pack on the back; None if there is none
    pack_pose: Float[Array, " 7"]  #: Centre [m] and rotation ``wxyz`` of the pack
    drawings: tuple[Drawing, ...]  #: Drawings of the controller
    history: "RecentHistory"  #: The last seconds
    end_message: str  #: Reason why the simulation has ended; empty while it runs


@dataclass(frozen=True, eq=False, kw_only=True)
class RecentHistory:
    """The last seconds of a session, one row per control step."""

    time: Float[Array, " n"]  #: Time [s]
    angles: Float[Array, "n n_hinges"]  #: Angles of the hinges [rad]
    torques: Float[Array, "n n_hinges"]  #: Torques of the motors [N m]
    #: Vertical ground reaction force on the right and the left foot [N]
    vertical: Float[Array, "n 2"]
    cop: Float[Array, "n 2"]  #: Centre of pressure of both feet, horizontal [m]; NaN in the air


class History:
    """Ring buffer of the last seconds of a world."""

    def __init__(self, world: World):
        self._n = 0
        self._rows = max(2, round(HISTORY_DURATION * world.control_rate))
        hinges = len(world.human.coordinates)
        sizes = {"time": (), "angles": (hinges,), "torques": (hinges,)}
        sizes |= {"vertical": (2,), "cop": (2,)}
        self._values = {name: np.zeros((2 * self._rows, *size)) for name, size in sizes.items()}
        self._feet = np.array([[s.side == side for s in world.sites] for side in SIDES], float)

    def append(
        self, world: World, force: Float[Array, "n_sites 3"], point: Float[Array, "n_sites 3"]
    ) -> None:
        """Append the present step."""
        up = np.maximum(force[:, 2], 0.0)
        load = float(up.sum())
        loaded = load > MIN_LOAD * world.human.mass * float(-world.model.opt.gravity[2])
        if self._n == 2 * self._rows:  # move the newer half to the front
            for values in self._values.values():
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
            self._values[name][self._n] = value
        self._n += 1

    def recent(self) -> RecentHistory:
        """Return a copy of the last seconds."""
        first = max(0, self._n - self._rows)
        return RecentHistory(
            **{name: values[first : self._n].copy() for name, values in self._values.items()}
        )
