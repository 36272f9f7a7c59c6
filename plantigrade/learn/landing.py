"""Ground reaction between two decisions, seen at every step of the physics.

The impact of a foot is over in less than a decision of 1/30 s, whose mean force hides it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.world.world import World

PLATE_CUTOFF = 20.0
"""Cutoff frequency of the filtered force, as of recorded plates [Hz]."""
OFF_LOAD = 0.02
"""A foot with less load is off the ground [body weights]; chosen."""
ON_LOAD = 0.05
"""A foot with more load is on the ground [body weights]; chosen."""


@dataclass(frozen=True, eq=False)
class Landing:
    """Ground reaction in the last decision, one row per world."""

    #: Maximum of the vertical force of both feet, low-passed at 20 Hz [body weights]
    peak: Float[Array, " n"]
    trough: Float[Array, " n"]  #: Its minimum [body weights]
    #: Vertical force of the right and the left foot at the end [body weights]
    loads: Float[Array, "n 2"]
    #: Downward speed of an ankle before its foot met the ground, the greater one of two; zero
    #: without a touchdown [m/s]
    speed: Float[Array, " n"]


class LandingWatch:
    """Watches the ground reaction of persons in parallel worlds.

    The sum of all contact forces on a person is the constraint force on the root's translation,
    because stops of joints and contacts within the body cancel there.

    Args:
        worlds: Worlds of one person with equal settings.

    Attributes:
        watchers: Functions to call after each step of the physics, one per world.
    """

    def __init__(self, worlds: Sequence[World]):
        first, n = worlds[0], len(worlds)
        human = first.human
        self._worlds, self._weight = worlds, human.mass * GRAVITY
        self._group = np.array([SIDES.index(site.side) for site in first.sites])
        self._feet = human.both("foot")
        # A filter of first order, exact for a force that is constant within a step.
        self._share = 1.0 - float(np.exp(-2.0 * np.pi * PLATE_CUTOFF / first.rate))
        self._level, self._peak, self._trough = [1.0] * n, [1.0] * n, [1.0] * n
        self._heights, self._speeds = np.zeros((n, 2)).tolist(), np.zeros((n, 2)).tolist()
        self._loads = np.zeros((n, len(SIDES)))
        self.watchers = [self._watcher(i) for i in range(n)]

    def start(self, which: Sequence[int]) -> None:
        """Begin episodes of some worlds, at a force of one body weight."""
        for i in which:
            self._level[i] = self._peak[i] = self._trough[i] = 1.0
            data = self._worlds[i].data
            self._heights[i] = [float(data.xpos[foot, 2]) for foot in self._feet]
            self._speeds[i] = [0.0, 0.0]
            self._loads[i] = self._feet_loads(i)

    def read(self) -> Landing:
        """Return the landing of the decision that is over, and begin the next."""
        before, n = self._loads, len(self._worlds)
        self._loads = np.array([self._feet_loads(i) for i in range(n)])
        met = (before < OFF_LOAD) & (self._loads > ON_LOAD)
        speed = np.where(met, self._speeds, 0.0).max(axis=1)
        found = Landing(np.array(self._peak), np.array(self._trough), self._loads, speed)
        self._peak, self._trough = list(self._level), list(self._level)
        self._speeds = np.zeros((n, 2)).tolist()
        return found

    def _feet_loads(self, i: int) -> Float[Array, " 2"]:
        world, up = self._worlds[i], np.array([0.0, 0.0, 1.0])
        return world.contacts.group_loads(world.data, self._group, up) / self._weight

    def _watcher(self, i: int) -> Callable[[mujoco.MjData], None]:
        """Return the function that watches a world."""
        data, rate = self._worlds[i].data, self._worlds[i].rate
        reaction, place, (right, left) = data.qfrc_constraint, data.xpos, self._feet
        share, weight = self._share, self._weight

        def watch(_: mujoco.MjData) -> None:
            level = self._level[i]
            level += share * (reaction.item(2) / weight - level)
            self._level[i] = level
            self._peak[i] = max(self._peak[i], level)
            self._trough[i] = min(self._trough[i], level)
            # MuJoCo leaves the positions from which it made the step.
            heights, speeds = self._heights[i], self._speeds[i]
            for k, foot in ((0, right), (1, left)):
                z = place.item(foot, 2)
                speeds[k] = max(speeds[k], (heights[k] - z) * rate)
                heights[k] = z

        return watch
