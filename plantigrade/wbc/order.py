"""Tasks in strict order of priority, and their rows."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.wbc.level import Level
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks import Task

UPPER_BODY = (
    "arm_",
    "elbow_",
    "pro_sup",
    "wrist_",
    "fingers_",
    "clavicle_",
    "neck_",
    "lower_neck_",
    "upper_neck_",
)


@dataclass(frozen=True, kw_only=True)
class OrderSettings:
    """Use of the freedom that tasks leave."""

    spared_readiness: float = 0.1
    """Weight of spared coordinates in tasks, relative to the others [1]. Chosen: people who walk do
    not wave their arms to lift the centre of mass by a millimetre, though the arms could where
    the legs are nearly straight."""
    rest_damping: float = 5.0
    """Damping of the freedom that is left, where there is no posture [1/s]. Chosen."""


@dataclass(frozen=True)
class TaskOrder:
    """Tasks in strict order.

    Attributes:
        levels: The tasks of each level, most important first.
        posture: A task of all coordinates, preferred where the levels leave freedom; rest if
            absent. It is the lowest level of all.
        spared: First letters of coordinates that the tasks use least where others can do it.
        settings: Use of the freedom that tasks leave.
    """

    levels: Sequence[Sequence[Task]]
    posture: Task | None = None
    spared: tuple[str, ...] = ()
    settings: OrderSettings = OrderSettings()

    @property
    def tasks(self) -> tuple[Task, ...]:
        """All tasks above the posture, in order."""
        return tuple(task for level in self.levels for task in level)

    @property
    def numbered(self) -> list[tuple[int, Task]]:
        """All tasks in order, the posture last, with the number of their level, from 1."""
        levels = [*self.levels, *([[self.posture]] if self.posture else [])]
        return [(k, task) for k, level in enumerate(levels, start=1) for task in level]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the tasks, in order."""
        return tuple(task.name for _, task in self.numbered)

    @property
    def meanings(self) -> list[str]:
        """Purpose of each task, in one sentence."""
        docs = ((type(task).__doc__ or "").strip() for _, task in self.numbered)
        return [doc.split("\n")[0].replace("`", "") for doc in docs]

    def rows(self, state: BodyState, time: float) -> list[list[Rows]]:
        """Return the rows of each task of each level."""
        return [[task.rows(state, time) for task in level] for level in self.levels]

    def preferred(self, state: BodyState, time: float) -> Float[Array, " nv"]:
        """Return the generalised acceleration that is preferred where the levels leave freedom."""
        if self.posture is None:
            return -self.settings.rest_damping * state.qvel
        return self.posture.acceleration(state, time)

    def readiness(self, human: Human) -> Float[Array, " nv"]:
        """Return how readily each coordinate is used by tasks that could do without it."""
        spared = self.settings.spared_readiness
        hinges = [spared if c.startswith(self.spared) else 1.0 for c in human.coordinates]
        return np.array([1.0] * 6 + hinges)


def stacked(levels: Sequence[Level]) -> Level:
    """Return the rows of several levels as one."""
    active = [level for level in levels if len(level.lower)] or levels[:1]
    if len(active) == 1:
        return active[0]
    lower = np.concatenate([r.lower for r in active])
    equal = all(r.lower is r.upper for r in active)
    return Level(
        np.concatenate([r.matrix for r in active]),
        lower,
        lower if equal else np.concatenate([r.upper for r in active]),
        " and ".join(r.name for r in active),
    )


def scaled(level: Level, by: Float[Array, " n"]) -> Level:
    """Return a level in unknowns that are divided by factors."""
    return Level(level.matrix * by, level.lower, level.upper, level.name)
