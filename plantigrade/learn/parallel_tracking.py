"""Persons who track a reference walk in several worlds at once, the basis of both environments."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.kinematics.state import BodyState
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.landing import LandingWatch
from plantigrade.learn.mirror import check_symmetry
from plantigrade.learn.policy_interface import PolicyInterface
from plantigrade.learn.randomisation import RandomTerrain
from plantigrade.learn.reference import ReferenceMotion
from plantigrade.learn.reward import LEAN_WEIGHTS, Reward, RewardWeights
from plantigrade.learn.rules import Rules
from plantigrade.world import StablePD, on_ground
from plantigrade.world.batch_motors import BatchMotors

MAX_COM_ERROR = 0.6  # [m] error of the centre of mass that ends an episode
MAX_PUSHED_COM_ERROR = 1.2  # [m] the same with random pushes
MIN_PELVIS_HEIGHT = 0.7  # minimum height of the pelvis, as a fraction of that in standing
MIN_UPRIGHT = (
    0.5  # minimum cosine of the angle between the long axis of the pelvis and the vertical
)
FELL, LOST, DIVERGED = "fell", "lost", "diverged"


class ParallelTracking:
    """Persons in parallel worlds who track one reference.

    Attributes:
        reference: Reference motion.
        worlds: The worlds.
        form: Observations and actions.
        weights: Weights of the reward.
        action: Layout of actions.
        observation: Layout of observations.
    """

    def __init__(self, rules: Rules, n: int = 1):
        lean = rules.form == "lean"
        self.rules, self.reference = rules, ReferenceMotion.of(rules.reference)
        human = self.reference.human
        self.worlds = tuple(rules.world(human) for _ in range(n))
        if rules.mirrored:
            check_symmetry(self.reference)
        self.form = PolicyInterface(human, rules)
        self.action, self.observation = self.form.action, self.form.observation
        self.weights = rules.weights or (LEAN_WEIGHTS if lean else RewardWeights())
        self._reward = Reward(self.reference, self.weights)
        self._motors = BatchMotors(self.worlds)
        self._view = BatchState(human, [(w.model, w.data) for w in self.worlds])
        rest = BodyState(human, human.standing())
        self._feet = np.array(human.both("foot")) - 1
        self._ankle = min(float(rest.origin(f"foot_{side}")[2]) for side in SIDES)
        self._low = MIN_PELVIS_HEIGHT * float(human.standing()[2])
        self._begin = np.zeros(n)
        self._landing = LandingWatch(self.worlds) if self.weights.landing else None
        self._relief = RandomTerrain(rules.terrain) if rules.terrain else None
        self._lost = MAX_PUSHED_COM_ERROR if rules.pushes else MAX_COM_ERROR
        self._constant_gains = not self.action.joints and not rules.passive
        ground = self.worlds[0].ground
        self._level = ground == Ground(friction=ground.friction)

    @property
    def resolved_rules(self) -> Rules:
        """The rules, with the defaults of their form filled in."""
        action = self.action
        return replace(
            self.rules,
            reference=self.reference,
            gains=bool(action.joints),
            base=action.gains,
            reach=action.reach,
        )

    @property
    def time(self) -> Float[Array, " n"]:
        """Time of the reference [s]."""
        return self._begin + [world.time for world in self.worlds]

    @property
    def phase(self) -> Float[Array, " n"]:
        """Phase of the stride, from 0 to 1."""
        return np.asarray(self.reference.phase(self.time))

    def start_episodes(
        self, which: Sequence[int], parts: Sequence[float], seeds: Sequence[int]
    ) -> None:
        """Start episodes of some persons on the reference."""
        for i, part, seed in zip(which, parts, seeds, strict=True):
            world, self._begin[i] = self.worlds[i], part * self.reference.period
            frame = self.reference.at(float(self._begin[i]))
            qpos = frame.qpos.copy()
            if self._level:
                qpos[2] += frame.depth
            else:
                if self._relief is not None:
                    self._relief.lay(world, int(seed))
                qpos = on_ground(self.reference.human, world.ground, qpos)
            world.reset(int(seed), qpos=qpos, qvel=frame.qvel)
            if self._constant_gains:
                stiffness, damping = self.action.fixed
                command = StablePD(qpos[7:], stiffness=stiffness, damping=damping)
                world.actuators.command(command, world.data)
        self._view.update(which)
        if self._landing is not None:
            self._landing.start(which)

    def observations(self) -> Float[np.ndarray, "n size"]:
        """Return the observations, one row per person."""
        time = self.time
        phase = np.asarray(self.reference.phase(time))
        return self.form.observe(self._view, self.reference.at(time), phase)

    def step(
        self, action: Float[np.ndarray, "n k"]
    ) -> tuple[Float[Array, " n"], list[str], Any, dict[str, Float[Array, " n"]]]:
        """Apply actions for one control step.

        Returns:
            Rewards; the reason why each episode has ended, empty if it has not; whether each has
            reached its time limit; the terms of the rewards.

        Raises:
            ParameterError: If the actions are not one row of finite numbers per person.
        """
        time = self.time
        bounded = self.form.decode(action, np.asarray(self.reference.phase(time)))
        time = time + 1.0 / self.worlds[0].control_rate
        frame = self.reference.at(time)
        self._move(bounded, frame)
        whole = [i for i, world in enumerate(self.worlds) if world.diverged is None]
        self._view.update(whole)
        landing = None if self._landing is None else self._landing.read()
        phase = np.asarray(self.reference.phase(time))
        rewards, terms = self._reward.of(self._view, frame, phase, landing)
        ends = self._ends(frame)
        rewards = np.where([end == DIVERGED for end in ends], 0.0, rewards)
        over = time - self._begin >= self.rules.duration - 1e-9
        if not self.reference.cyclic:
            over |= time >= self.reference.period
        return rewards, ends, over & [not end for end in ends], terms

    def _move(self, action: Float[Array, "n k"], frame: Any) -> None:
        constant = self._constant_gains
        stiffness, damping = self.action.fixed if constant else self.action.gains_of(action)
        force = stiffness * self.action.targets(action, frame)
        if self.action.feed_rates:
            force += damping * frame.qvel[:, 6:]
        if constant:
            for world, each in zip(self.worlds, force, strict=True):
                world.actuators.set_force(world.data, each)
        else:
            self._motors.command(self._view.angles, force, stiffness, damping)
        self._advance()

    def _advance(self) -> None:
        """Do one control step in all worlds."""
        watchers = [None] * len(self.worlds) if self._landing is None else self._landing.watchers
        for world, watch in zip(self.worlds, watchers, strict=True):
            world.repeat_command(watch)

    def _ends(self, frame: Any) -> list[str]:
        """Return the reason why each episode ends; empty if it does not."""
        view = self._view
        x, y = view.quat[:, 1], view.quat[:, 2]
        down = 1.0 - 2.0 * (x * x + y * y) < MIN_UPRIGHT
        height = (
            view.positions[:, 0, 2] - view.positions[:, self._feet, 2].min(axis=1) + self._ankle
        )
        down |= height < self._low
        off = view.com - frame.com
        lost = np.einsum("ij,ij->i", off, off) > self._lost**2
        ends = []
        for world, fell, astray in zip(self.worlds, down.tolist(), lost.tolist(), strict=True):
            if world.diverged is not None:
                ends.append(DIVERGED)
            elif fell or world.fall is not None:
                ends.append(FELL)
            else:
                ends.append(LOST if astray else "")
        return ends
