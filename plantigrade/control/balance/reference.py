"""What a balanced person is to do: a posture held, or a motion, and which points press."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import PointSet, State, sweep
from plantigrade.models import Human
from plantigrade.motion import Motion

LOW, SLOW = 0.02, 0.25
"""A sphere of a recorded foot presses that is lower and slower than this [m, m/s]."""


@dataclass(frozen=True, eq=False)
class Wanted:
    """What is wanted at one time.

    Attributes:
        qpos: The configuration.
        qvel: Its rate.
        qacc: The rate of that.
        com: Where the centre of mass is in it [m].
        com_velocity: Its velocity [m/s].
        com_acceleration: Its acceleration [m/s²].
        places: Where the contact spheres of the feet are [m].
        presses: Which of them are to be on the ground.
        dear: How much more than usual a force of each costs.
    """

    qpos: Float[Array, " nq"]
    qvel: Float[Array, " nv"]
    qacc: Float[Array, " nv"]
    com: Float[Array, " 3"]
    com_velocity: Float[Array, " 3"]
    com_acceleration: Float[Array, " 3"]
    places: Float[Array, "n_sites 3"]
    presses: Bool[Array, " n_sites"]
    dear: float | Float[Array, " n_sites"] = 1.0


@runtime_checkable
class Reference(Protocol):
    """What is wanted, as a function of time."""

    def at(self, time: float) -> Wanted:
        """Return what is wanted at a time since the start [s]."""
        ...


class Held:
    """A posture that is held, on both feet.

    Args:
        human: The person.
        qpos: The posture.
    """

    def __init__(self, human: Human, qpos: Float[Array, " nq"]):
        state, points = State(human, qpos), PointSet.of(human, contact_sites(human))
        nothing, rest = np.zeros(human.model.nv), np.zeros(3)
        places = state.position(points)
        everywhere = np.ones(len(points), dtype=bool)
        self.wanted = Wanted(
            np.array(qpos), nothing, nothing, state.com, rest, rest, places, everywhere
        )

    def at(self, time: float) -> Wanted:
        """Return the posture."""
        return self.wanted


class Followed:
    """A motion; before its first frame and after its last one the person stands still.

    Args:
        human: The person.
        motion: Their motion.
        presses: Which contact spheres of the feet press the ground in each frame; those that are
            low and slow if absent.
        ground: What the motion happened on; level if absent.
        flights: From when to when the body is in the air, by plan [s].

    Attributes:
        dear: How much more than usual the force of every sphere costs in each frame.
    """

    def __init__(
        self,
        human: Human,
        motion: Motion,
        presses: Bool[Array, "n n_sites"] | None = None,
        ground: Ground | None = None,
        flights: Sequence[tuple[float, float]] = (),
    ):
        self.flights = tuple(flights)
        sites = contact_sites(human)
        points = PointSet.of(human, sites)
        states = [(s.com, s.position(points)) for s in sweep(human, motion.qpos)]
        self.motion, self.time = motion, motion.time - motion.time[0]
        self.com = np.array([com for com, _ in states])
        self.places = np.array([places for _, places in states])
        own = motion.qacc
        self.qacc = np.gradient(motion.qvel, self.time, axis=0) if own is None else own
        if presses is not None:
            self.presses: Array = presses
        else:
            ground = ground or Ground()
            radius = np.array([s.radius for s in sites])
            gap = self.places @ ground.normal - ground.under(self.places) - radius
            speed = np.linalg.norm(np.gradient(self.places, self.time, axis=0), axis=2)
            self.presses = (gap < LOW + gap.min()) & (speed < SLOW)
        self.com_velocity = np.gradient(self.com, self.time, axis=0)
        self.com_acceleration = np.gradient(self.com_velocity, self.time, axis=0)

        self.dear = np.ones(self.presses.shape)

    def at(self, time: float) -> Wanted:
        """Return the motion at a time after its first frame [s]."""
        moves = time < self.time[-1]
        i = int(np.searchsorted(self.time, time, side="right")) - 1
        i = min(max(i, 0), len(self.time) - 2)
        first, last = float(self.time[i]), float(self.time[i + 1])
        u = min(max((time - first) / (last - first), 0.0), 1.0)

        def between(values: Array) -> Array:
            return (1 - u) * values[i] + u * values[i + 1]

        q = self.motion.qpos[i : i + 2]
        if q[0, 3:7] @ q[1, 3:7] < 0:
            q = q * np.where(np.isin(np.arange(q.shape[1]), range(3, 7)), [[1.0], [-1.0]], 1.0)
        qpos = (1 - u) * q[0] + u * q[1]
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        return Wanted(
            qpos,
            moves * between(self.motion.qvel),
            moves * between(self.qacc),
            between(self.com),
            moves * between(self.com_velocity),
            moves * between(self.com_acceleration),
            between(self.places),
            self.presses[i + 1 if u > 0.5 else i],
            self.dear[i + 1 if u > 0.5 else i],
        )
