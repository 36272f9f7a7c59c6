"""Rules of an episode of tracking."""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.learn.action import Gains
from plantigrade.learn.randomisation import RandomPushes, RandomTerrain
from plantigrade.learn.reference import ReferenceMotion
from plantigrade.learn.reward import RewardWeights
from plantigrade.models import Human
from plantigrade.options import shown
from plantigrade.record import Record, Run
from plantigrade.world import Disturbance, World
from plantigrade.world.grounds import ground_named, platform_named

RATE = 150.0  # [1/s] steps of the physics
CONTROL_RATE = 30.0  # [1/s] decisions of the policy, as in [Park2020]_
N_SOLVER_SWEEPS = 10
"""Iterations of the projected Gauss-Seidel contact solver; joint velocities differ by 0.03 rad/s
per decision from Newton's converged solution, which takes 50 % more time."""
FORMS = ("lean", "paper")


@dataclass(frozen=True, kw_only=True, eq=False)
class Rules:
    """Rules of an episode.

    Attributes:
        reference: Reference motion and person: a run (fitted, reproduced or synthesised), its
            folder, a :class:`~plantigrade.record.Record` or a
            :class:`~plantigrade.learn.reference.ReferenceMotion`. The published mean walk on a
            person of 66 coordinates if absent.
        form: ``"lean"``, with which walking was learned in a million steps: the joints of the body
            are displaced, the rates of the reference are fed forward, and the centre-of-mass error
            is observed; or ``"paper"``, state and action as printed in [Park2020]_.
        gains: Whether gains of the feet are part of the action; true for ``"paper"`` if absent.
        base: Gains of the joints; those of the form if absent.
        weights: Weights of the reward; those of the form if absent.
        reach: Displacement of a joint at an action of 1 [rad]; 0.6 for ``"lean"``, 1 for
            ``"paper"`` if absent.
        ground: The ground or its name (``"bumps:2"``, ``"tilting:3"``).
        disturbances: Further disturbances; their times are those of the episode.
        terrain: Maximum height of random terrain on level ground [m]; none if zero.
        pushes: Maximum force of random pushes (:class:`RandomPushes`) [N]; none if zero.
        duration: Maximum duration of an episode [s].
        rate: Steps of the physics per second, an integer multiple of ``control_rate`` [1/s].
        control_rate: Decisions per second [1/s].
        passive: Whether joints have passive moments of tissue; those of the paper do not.
        recording: Whether episodes are recorded, which takes 10 % more time.
        start: Initial phase of every episode, from 0 to 1; random if absent.
        mirrored: Whether the second half of the stride is mirrored, so that the policy learns one
            half only; for ``"lean"`` and a symmetric reference.

    Raises:
        ParameterError: If a value is not allowed.
    """

    reference: str | Path | Run | Record | ReferenceMotion | None = None
    form: str = "lean"
    gains: bool | None = None
    base: Gains | None = None
    weights: RewardWeights | None = None
    reach: float | None = None
    ground: Ground | str = "flat"
    disturbances: Sequence[Disturbance] = ()
    terrain: float = 0.0
    pushes: float = 0.0
    duration: float = 10.0
    rate: float = RATE
    control_rate: float = CONTROL_RATE
    passive: bool = False
    recording: bool = False
    start: float | None = None
    mirrored: bool = False

    def __post_init__(self):
        if self.form not in FORMS:
            raise ParameterError(f"form={self.form!r} must be one of {', '.join(FORMS)}")
        if not self.duration > 0:
            raise ParameterError(f"duration={self.duration:g} s must be positive")
        if self.reach is not None and not 0.0 < self.reach < np.inf:
            raise ParameterError(f"reach={self.reach:g} rad must be positive")
        if self.mirrored and self.form != "lean":
            raise ParameterError("mirrored=True needs form='lean'")
        if self.terrain and self.ground != "flat":
            raise ParameterError("terrain and ground cannot be combined; give one")
        check_phase("start", self.start)

    def world(self, human: Human) -> World:
        """Return a world for an episode."""
        ground = self.ground
        plate = platform_named(ground) if isinstance(ground, str) else None
        if isinstance(ground, str):
            ground = ground_named("flat" if plate else ground)
        if self.terrain:
            ground = RandomTerrain(self.terrain).ground()
        acting = [] if plate is None else [plate]
        acting += [RandomPushes(force=self.pushes)] if self.pushes else []
        world = World(
            human,
            ground,
            (*acting, *self.disturbances),
            rate=self.rate,
            control_rate=self.control_rate,
            passive=self.passive,
            recording=self.recording,
            exact_limits=False,
        )
        world.model.opt.solver = mujoco.mjtSolver.mjSOL_PGS
        world.model.opt.iterations = N_SOLVER_SWEEPS
        # This solver is 25 % faster with dense Jacobians; Newton's is with sparse ones.
        world.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        return world


def check_phase(name: str, part: Any) -> float | None:
    """Return the initial phase of an episode, or None if it is random."""
    if part is None:
        return None
    if not isinstance(part, Real) or not 0.0 <= float(part) <= 1.0:
        raise ParameterError(f"{name}={shown(part)} must be a phase of the stride, from 0 to 1")
    return float(part)
