"""A simulated world: a person on a ground, with disturbances, stepped by any controller.

::

    world = World(Human.create(), disturbances=(Push(force=100.0, duration=0.2, time=1.0),))
    state = world.reset()
    while world.time < 2.0:
        state = world.step(controller(state))
    record = world.record()

The physics runs at ``rate``, the controller at ``control_rate``; its command is lasting in between.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.models.mujoco_warnings import collected_warnings
from plantigrade.record import Record
from plantigrade.record.scene_objects import PLACES
from plantigrade.record.signals import CONTROLLER
from plantigrade.threads import on_one_thread
from plantigrade.world.actuators import Actuators
from plantigrade.world.command import AnyCommand, Command
from plantigrade.world.contacts import Contacts
from plantigrade.world.controller import AnyController, Rates, controller_from
from plantigrade.world.disturbance import Disturbance
from plantigrade.world.falls import Fall, FallWatch
from plantigrade.world.recorder import Recorder, record_of
from plantigrade.world.simulated_world import SimulatedWorld
from plantigrade.world.standing import standing_on
from plantigrade.world.state import State
from plantigrade.world.world_model import world_model

RATE, CONTROL_RATE = Rates().physics, Rates().control
"""Default rates of the physics and of the controller [1/s]."""
MAX_SPEED = 300.0  # [m/s, rad/s] of any coordinate; beyond it the simulation has diverged
LIMITS_INTERVAL = 0.002  # [s] between updates of torque limits that change
MAX_DURATION = 3600.0  # [s] of a simulation


class World(SimulatedWorld):
    """A person on a ground, with disturbances, simulated by MuJoCo.

    Args:
        ground: The ground; level if absent.
        disturbances: Disturbances that act on the person.
        rate: Steps of the physics per second [1/s].
        control_rate: Commands per second; ``rate`` is a whole multiple of it [1/s].
        record_rate: Frames kept per second, likewise; ``control_rate`` if absent [1/s].
        recording: Whether frames are kept for :meth:`record`.
        passive: Whether joints have passive moments of tissue.
        torque_rise: Rise time of a motor from zero to its maximum torque [s]; zero for none.
        torque_speed: Whether a motor gives less torque the faster its joint turns, as a muscle.
        exact_limits: Whether torque limits include the implicit part of stable PD; without it a
            simulation is 10 % faster.
        qpos: Initial configuration; quiet standing if absent.
        qvel: Initial velocity; at rest if absent.
        seed: Seed of :attr:`random`.

    Attributes:
        model: MuJoCo's model; the person's coordinates come first.
        data: MuJoCo's data.
        sites: The contact spheres of the feet, and the additional sites.
        memory: State of disturbances and controllers until the next reset.
        random: Generator of random numbers for disturbances and controllers.
        fall: The fall of the person; None before it.
        diverged: Time at which the simulation diverged [s]; None before that.

    Raises:
        ParameterError: If the rates do not fit, or the initial state does not fit the person.
    """

    def __init__(
        self,
        human: Human,
        ground: Ground | None = None,
        disturbances: Sequence[Disturbance] = (),
        *,
        rate: float = RATE,
        control_rate: float = CONTROL_RATE,
        record_rate: float | None = None,
        recording: bool = True,
        passive: bool = True,
        torque_rise: float = 0.0,
        torque_speed: bool = False,
        exact_limits: bool = True,
        qpos: Float[Array, " nq"] | None = None,
        qvel: Float[Array, " nv"] | None = None,
        sites: Sequence[ContactSite] = (),
        seed: int = 0,
    ):
        self.human, self.ground = human, ground or Ground()
        self.disturbances, self.seed, self.recording = tuple(disturbances), seed, recording
        self.rate, self.control_rate = float(rate), float(control_rate)
        self.record_rate = float(control_rate if record_rate is None else record_rate)
        self._per_control = _multiple(self.rate, self.control_rate, "control_rate")
        self._per_frame = _multiple(self.rate, self.record_rate, "record_rate")
        intervals = [d.interval for d in self.disturbances] + (
            [LIMITS_INTERVAL] if torque_rise or torque_speed else []
        )
        self._max_steps = min(
            [
                self._per_control,
                *(max(1, round(t * self.rate)) for t in intervals if np.isfinite(t)),
            ]
        )
        if not 0.0 <= torque_rise < np.inf:
            raise ParameterError(f"torque_rise={torque_rise} s must be zero or more")
        additions = [lambda spec, d=d: d.add(spec, human) for d in self.disturbances]
        self.model = world_model(
            human, self.ground, step=1.0 / self.rate, sites=sites, additions=additions
        )
        self.data = mujoco.MjData(self.model)
        # Nothing acts or is recorded within a control step.
        self._undisturbed = not (recording or self.disturbances or torque_rise or torque_speed)
        self.sites = (*contact_sites(human), *sites)
        self.actuators = Actuators(
            human,
            self.model,
            passive=passive,
            rise=torque_rise,
            slows=torque_speed,
            exact=exact_limits,
        )
        self.contacts = Contacts(human, self.model, self.sites)
        self._falls = FallWatch(human, self.model)
        self._body = BodyState(human, human.standing())
        nq, nv = human.model.nq, human.model.nv
        self._qpos = standing_on(human, self.ground) if qpos is None else _finite("qpos", qpos, nq)
        self._qvel = np.zeros(nv) if qvel is None else _finite("qvel", qvel, nv)
        self.reset()

    def allow_contacts_of(self, qpos: Float[Array, "n_frames nq"]) -> None:
        """Let bodies that touch level ground in a motion touch it without having fallen."""
        if self.ground.level:
            self._falls.allow(qpos)

    def reset(
        self,
        seed: int | None = None,
        *,
        qpos: Float[Array, " nq"] | None = None,
        qvel: Float[Array, " nv"] | None = None,
    ) -> State:
        """Restart the simulation and return the first state.

        Args:
            seed: Seed of :attr:`random`; the same as before if absent.
            qpos: Initial configuration; that of the constructor if absent.
            qvel: Initial velocity; that of the constructor if absent.

        Raises:
            ParameterError: If the state does not fit the person.
        """
        self.seed = self.seed if seed is None else seed
        self.random = np.random.default_rng(self.seed)
        human, data = self.human, self.data
        mujoco.mj_resetData(self.model, data)
        nq, nv = human.model.nq, human.model.nv
        data.qpos[:nq] = self._qpos if qpos is None else _finite("qpos", qpos, nq)
        data.qvel[:nv] = self._qvel if qvel is None else _finite("qvel", qvel, nv)
        self.actuators.reset()
        self._steps, self._pushed, self._last_pushes, self._signals = 0, [], [], {}
        self.memory: dict[Any, Any] = {}
        self.fall: Fall | None = None
        self.diverged: float | None = None
        self._recorder = Recorder(human, self.sites, self.contacts) if self.recording else None
        mujoco.mj_forward(self.model, data)
        for disturbance in self.disturbances:
            disturbance.reset(self)
        edges = {round(t * self.rate) for d in self.disturbances for t in d.edges()}
        self._edges = sorted(edges)
        return State(self)

    def step(self, command: AnyCommand = None) -> State:
        """Apply a command for one control step and return the state after it.

        A diverged world no longer moves.

        Raises:
            ParameterError: If the command does not fit the person.
        """
        self.advance(command)
        return State(self)

    def advance(self, command: AnyCommand = None) -> None:
        """Apply a command for one control step without creating a :class:`State`."""
        if self.diverged is not None:
            return
        done = self.actuators.command(command, self.data)
        self._signals = {f"{CONTROLLER}{name}": value for name, value in done.signals.items()}
        self.repeat_command()

    def repeat_command(self, watch: Callable[[mujoco.MjData], None] | None = None) -> None:
        """Do one control step with the last command.

        Args:
            watch: Called after every step of the physics.
        """
        if self.diverged is not None:
            return
        data = self.data
        recorder = self._recorder
        good = 0 if recorder is None else len(recorder)
        with collected_warnings():  # the world itself reports divergence
            self._advance_to(self._steps + self._per_control, watch)
        speed = data.qvel
        if not (
            speed.max() < MAX_SPEED and speed.min() > -MAX_SPEED
        ):  # NaN is not less than anything
            self.diverged = self.time
            if recorder is not None:
                recorder.cut(max(good, 1))
        elif self.fall is None:
            self.fall = self._falls.detect(data, self.time)

    def _advance_to(self, end: int, watch: Callable[[mujoco.MjData], None] | None = None) -> None:
        """Advance the physics to a given step."""
        data, lasting = self.data, self._pushed
        if self._undisturbed and not lasting and watch is None:
            self.actuators.step(data, end - self._steps)
            self._steps, self._last_pushes = end, []
            return
        while self._steps < end:
            self._disturb(lasting)
            recorder = self._recorder
            if recorder is not None and self._steps % self._per_frame == 0:
                recorder.before(data, self.time)
                self.actuators.update_limits(data, 1.0 / self.rate)
                self.actuators.step(data, 1)
                self._record_frame(recorder)
                self._steps += 1
                if watch is not None:
                    watch(data)
                continue
            stop = min([end, *self._edges[bisect_right(self._edges, self._steps) :][:1]])
            stop = min(stop, self._steps + (self._max_steps if watch is None else 1))
            if recorder is not None:
                stop = min(stop, (self._steps // self._per_frame + 1) * self._per_frame)
            self.actuators.update_limits(data, (stop - self._steps) / self.rate)
            self.actuators.step(data, stop - self._steps)
            self._steps = stop
            if watch is not None:
                watch(data)
        self._last_pushes, self._pushed = self._pushed, []
        if self._undisturbed:
            data.xfrc_applied[:] = 0.0

    @on_one_thread
    def simulate(
        self,
        controller: AnyController,
        duration: float,
        *,
        seed: int | None = None,
        after_fall: float = np.inf,
        reached: Callable[[float], None] | None = None,
    ) -> Record:
        """Restart the simulation, run a controller and return the Record.

        Args:
            duration: Duration, if the simulation does not diverge before [s].
            seed: Seed, as in :meth:`reset`.
            after_fall: Duration of the simulation after a fall [s]. If it is finite, joints are
                passive after the fall, because controllers assume a person on their feet.
            reached: Called after every control step with the share of the duration that is over.

        Raises:
            ParameterError: If the duration is not positive, or a command does not fit.
        """
        if not 0.0 < duration <= MAX_DURATION:
            raise ParameterError(
                f"duration={duration:g} s must be above 0 and at most {MAX_DURATION:g}"
            )
        control, state, end = controller_from(controller), self.reset(seed), duration
        while self.time < end - 0.5 / self.rate and self.diverged is None:
            if self.fall is not None and after_fall < np.inf:
                end = min(duration, self.fall.time + after_fall)
                state = self.step(Command())
            else:
                state = self.step(control(state))
            if reached is not None:
                reached(self.time / end)
        return self.record()

    def record(self) -> Record:
        """Return the Record of the simulation up to now.

        After divergence it has the frames before that only.

        Raises:
            ParameterError: If nothing was recorded.
        """
        if self._recorder is None:
            raise ParameterError("this world records no frames; create it with recording=True")
        recorder, data = self._recorder, self.data
        if self.diverged is None and self._steps % self._per_frame == 0:
            recorder.before(data, self.time)
            self._disturb([])
            mujoco.mj_forward(self.model, data)
            self._record_frame(recorder)
            self._pushed = []
            record = record_of(self, recorder)
            recorder.cut(-1)
            return record
        return record_of(self, recorder)

    def _disturb(self, lasting: list) -> None:
        """Apply the disturbances and pushes that act now."""
        self._pushed = list(lasting)
        for disturbance in self.disturbances:
            disturbance.act(self)
        self.data.xfrc_applied[:] = 0.0
        for body, force, arm in self._pushed:
            self.data.xfrc_applied[body, :3] += force
            if arm.any():  # a cross product takes half as long as a step of the physics
                self.data.xfrc_applied[body, 3:] += np.cross(arm, force)

    def _record_frame(self, recorder: Recorder) -> None:
        """Record the forces of the last step."""
        data, actuators = self.data, self.actuators
        step_contacts, constraint = self.contacts.read_step(data)
        motor = actuators.motor_torques(data)
        tau = actuators.joint_forces(data, constraint)
        most = len(self.human.body_names)
        pushed = [(b, f, data.xipos[b] + arm) for b, f, arm in self._pushed if b <= most]
        signals = dict(self._signals)
        if poses := [d.pose(self) for d in self.disturbances if d.scene_object is not None]:
            signals[PLACES] = np.array(poses)
        recorder.after(data, step_contacts, tau, motor, pushed, signals)


def _multiple(rate: float, slower: float, name: str) -> int:
    """Return the number of physics steps per period of a slower rate."""
    if not (np.isfinite([rate, slower]).all() and 0 < slower <= rate <= 1e5):
        raise ParameterError(f"{name}={slower:g} must be above 0 and at most rate={rate:g} 1/s")
    times = round(rate / slower)
    if abs(times * slower - rate) > 1e-6 * rate:
        near = [f"{rate / n:g}" for n in (times, times + 1)]
        raise ParameterError(
            f"rate={rate:g} must be a whole multiple of {name}={slower:g}, such as {near[0]} or "
            f"{near[1]}"
        )
    return times


def _finite(name: str, values: Float[Array, " k"], n: int) -> Float[Array, " n"]:
    """Return a copy of ``n`` numbers; raise if one is not finite."""
    numbers = np.array(values, dtype=float)
    if numbers.shape != (n,) or not np.isfinite(numbers).all():
        raise ParameterError(f"{name} of this person must be {n} finite numbers in one row")
    return numbers
