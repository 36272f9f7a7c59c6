"""A simulated world: a person on a ground, with disturbances, stepped by any controller.

::

    world = World(Human.create(), disturbances=(Push(force=100.0, duration=0.2, time=1.0),))
    state = world.reset()
    while world.time < 2.0:
        state = world.step(controller(state))
    record = world.record()

The physics runs at ``rate``, the controller at ``control_rate``; its command is held in between.
"""

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.record.things import PLACES
from plantigrade.threads import on_one_thread
from plantigrade.world.actuators import Actuators
from plantigrade.world.command import Command, Commanded
from plantigrade.world.contacts import Contacts
from plantigrade.world.controller import AnyController, Rates, controller_from
from plantigrade.world.disturbance import Disturbance
from plantigrade.world.falls import Fall, FallWatch
from plantigrade.world.recorded import record_of
from plantigrade.world.recorder import Recorder
from plantigrade.world.scene import world_model
from plantigrade.world.start import standing_on
from plantigrade.world.state import State

RATE, CONTROL_RATE = Rates().physics, Rates().control
"""Steps of the physics and of the controller, by default [1/s]."""
FASTEST = 300.0
"""A body of which anything is faster than this has diverged [m/s, rad/s]."""
LOOK = 0.002
"""So often the rise of torques is looked at [s]."""
LONGEST = 3600.0
"""Longest simulation [s]."""


class World:
    """A person on a ground, with disturbances, simulated by MuJoCo.

    Args:
        human: The person.
        ground: What they stand on; level if absent.
        disturbances: What else acts.
        rate: Steps of the physics per second [1/s].
        control_rate: Commands per second; ``rate`` is a whole multiple of it [1/s].
        record_rate: Frames kept per second, likewise; ``control_rate`` if absent [1/s].
        recording: Whether frames are kept for :meth:`record`.
        passive: Whether joints resist by themselves, as tissue does.
        torque_rise: How long a motor takes from nothing to its greatest torque [s]; at once if
            zero.
        exact_limits: Whether limits of torque hold for all of stable PD, or, a tenth faster, but
            for its part within a step.
        qpos: Where the person starts; quiet standing if absent.
        qvel: How fast; at rest if absent.
        sites: Further places of the body by which seats carry it.
        seed: Seed of :attr:`random`.

    Attributes:
        model: MuJoCo's model; the person's coordinates come first.
        data: MuJoCo's data.
        sites: The contact spheres of the feet, and the further places.
        memory: What disturbances, and controllers, keep until the next start.
        random: Generator of random numbers for disturbances and controllers.
        fall: How and when the person fell; None as long as it has not.
        diverged: When the simulation diverged [s]; None as long as it has not.

    Raises:
        ParameterError: If the rates do not fit, or something is no state of this person.
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
        looks = [d.interval for d in self.disturbances] + ([LOOK] if torque_rise else [])
        self._most = min(
            [self._per_control, *(max(1, round(t * self.rate)) for t in looks if np.isfinite(t))]
        )
        if not 0.0 <= torque_rise < np.inf:
            raise ParameterError(f"torque_rise={torque_rise} s must be zero or more")
        additions = [lambda spec, d=d: d.add(spec, human) for d in self.disturbances]
        self.model = world_model(
            human, self.ground, step=1.0 / self.rate, sites=sites, additions=additions
        )
        self.data = mujoco.MjData(self.model)
        # Nothing acts within a control step, and nobody looks.
        self._alone = not (recording or self.disturbances or torque_rise)
        self.sites = (*contact_sites(human), *sites)
        self.actuators = Actuators(
            human, self.model, passive=passive, rise=torque_rise, exact=exact_limits
        )
        self.contacts = Contacts(human, self.model, self.sites)
        self._falls = FallWatch(human, self.model)
        self._body = BodyState(human, human.standing())
        nq, nv = human.model.nq, human.model.nv
        self._qpos = standing_on(human, self.ground) if qpos is None else _finite("qpos", qpos, nq)
        self._qvel = np.zeros(nv) if qvel is None else _finite("qvel", qvel, nv)
        self.reset()

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._steps / self.rate

    def reset(
        self,
        seed: int | None = None,
        *,
        qpos: Float[Array, " nq"] | None = None,
        qvel: Float[Array, " nv"] | None = None,
    ) -> State:
        """Start anew and return the first state.

        Args:
            seed: Seed of :attr:`random`; the same as before if absent.
            qpos: Where the person starts; as the world was made if absent.
            qvel: How fast, likewise.

        Raises:
            ParameterError: If that is no state of this person.
        """
        self.seed = self.seed if seed is None else seed
        self.random = np.random.default_rng(self.seed)
        human, data = self.human, self.data
        mujoco.mj_resetData(self.model, data)
        nq, nv = human.model.nq, human.model.nv
        data.qpos[:nq] = self._qpos if qpos is None else _finite("qpos", qpos, nq)
        data.qvel[:nv] = self._qvel if qvel is None else _finite("qvel", qvel, nv)
        self.actuators.reset()
        self._steps, self._pushed, self._acted, self._signals = 0, [], [], {}
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

    def step(self, command: Commanded = None) -> State:
        """Do what a controller commands for one control step, and return the state after it.

        A world that has diverged stands still.

        Raises:
            ParameterError: If the command does not fit the person.
        """
        self.advance(command)
        return State(self)

    def advance(self, command: Commanded = None) -> None:
        """Do the same without a state, for those who read :attr:`data` themselves."""
        if self.diverged is not None:
            return
        done = self.actuators.command(command, self.data)
        self._signals = {f"controller.{name}": value for name, value in done.signals.items()}
        self.proceed()

    def proceed(self) -> None:
        """Do one control step with what was commanded last."""
        if self.diverged is not None:
            return
        data = self.data
        recorder = self._recorder
        good = 0 if recorder is None else len(recorder)
        # A world that diverges says so itself; MuJoCo would write a file.
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(_hear)
        try:
            self._advance(self._steps + self._per_control)
        finally:
            mujoco.set_mju_user_warning(before)
        speed = data.qvel
        if not (speed.max() < FASTEST and speed.min() > -FASTEST):  # NaN is not less than anything
            self.diverged = self.time
            if recorder is not None:
                recorder.cut(max(good, 1))
        elif self.fall is None:
            self.fall = self._falls.look(data, self.time)

    def _advance(self, end: int) -> None:
        """Step the physics up to a step of its own."""
        data, held = self.data, self._pushed
        if self._alone and not held:
            self.actuators.step(data, end - self._steps)
            self._steps, self._acted = end, []
            return
        while self._steps < end:
            self._disturb(held)
            recorder = self._recorder
            if recorder is not None and self._steps % self._per_frame == 0:
                recorder.before(data, self.time)
                self.actuators.ease(data, 1.0 / self.rate)
                self.actuators.step(data, 1)
                self._keep(recorder)
                self._steps += 1
                continue
            stop = min([end, *self._edges[bisect_right(self._edges, self._steps) :][:1]])
            stop = min(stop, self._steps + self._most)
            if recorder is not None:
                stop = min(stop, (self._steps // self._per_frame + 1) * self._per_frame)
            self.actuators.ease(data, (stop - self._steps) / self.rate)
            self.actuators.step(data, stop - self._steps)
            self._steps = stop
        self._acted, self._pushed = self._pushed, []
        if self._alone:
            data.xfrc_applied[:] = 0.0

    @on_one_thread
    def simulate(
        self,
        controller: AnyController,
        duration: float,
        *,
        seed: int | None = None,
        after_fall: float = np.inf,
    ) -> Record:
        """Start anew, let a controller move the person, and return what happened.

        Args:
            controller: What moves them.
            duration: How long, if the simulation does not diverge before [s].
            seed: As in :meth:`reset`.
            after_fall: How long it goes on after a fall [s]. Where that is limited, joints are
                passive from the fall on: controllers are made for people on their feet.

        Raises:
            ParameterError: If the duration is not positive, or a command does not fit.
        """
        if not 0.0 < duration <= LONGEST:
            raise ParameterError(f"duration={duration:g} s must be above 0 and at most {LONGEST:g}")
        control, state, end = controller_from(controller), self.reset(seed), duration
        while self.time < end - 0.5 / self.rate and self.diverged is None:
            if self.fall is not None and after_fall < np.inf:
                end = min(duration, self.fall.time + after_fall)
                state = self.step(Command())
            else:
                state = self.step(control(state))
        return self.record()

    def record(self) -> Record:
        """Return what has happened since the start, up to now.

        Where the simulation diverged, the frames before that.

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
            self._keep(recorder)
            self._pushed = []
            record = record_of(self, recorder)
            recorder.cut(-1)
            return record
        return record_of(self, recorder)

    def _disturb(self, held: list) -> None:
        """Let everything act that acts now."""
        self._pushed = list(held)
        for disturbance in self.disturbances:
            disturbance.act(self)
        self.data.xfrc_applied[:] = 0.0
        for body, force, arm in self._pushed:
            self.data.xfrc_applied[body, :3] += force
            self.data.xfrc_applied[body, 3:] += np.cross(arm, force)

    def _keep(self, recorder: Recorder) -> None:
        """Let the recorder have the step just done."""
        data, actuators = self.data, self.actuators
        taken, inside = self.contacts.take(data)
        motor = actuators.motor_torques(data)
        tau = actuators.joint_forces(data, inside)
        most = len(self.human.body_names)
        pushed = [(b, f, data.xipos[b] + arm) for b, f, arm in self._pushed if b <= most]
        signals = dict(self._signals)
        if seen := [d.place(self) for d in self.disturbances if d.thing is not None]:
            signals[PLACES] = np.array(seen)
        recorder.after(data, taken, tau, motor, pushed, signals)

    def push(
        self, body: int, force: Float[Array, " 3"], arm: Float[Array, " 3"] | None = None
    ) -> None:
        """Let a force act at a body, until the next control step or edge.

        For disturbances, and for whoever drags a body: call it before :meth:`step`.

        Args:
            body: Index of the body.
            force: Force, world [N].
            arm: From its centre of mass to where it acts, world [m]; there if absent.
        """
        lever = np.zeros(3) if arm is None else np.array(arm, dtype=float)
        self._pushed.append((body, np.array(force, dtype=float), lever))

    @property
    def pushes(self) -> Float[Array, "n 2 3"]:
        """Where something pushed at the end of the last control step [m], and its force [N]."""
        place = self.data.xipos
        acted = [(place[body] + arm, force) for body, force, arm in self._acted]
        return np.array(acted).reshape(-1, 2, 3)

    def say(self, name: str, value: float | Array) -> None:
        """Let a disturbance keep a number or array with the frames, as a signal of that name."""
        self._signals[name] = value

    def contact_force(self) -> Float[Array, "n_sites 3"]:
        """Return the force of the ground at each contact sphere in the last step [N]."""
        return self.contacts.forces(self.data)

    def evaluated(self, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]) -> BodyState:
        """Return the evaluated body at a configuration and velocity."""
        self._body = self._body.moved_to(qpos, qvel)
        return self._body


def _hear(_: str) -> None:
    """Take a warning of MuJoCo's."""


def _multiple(rate: float, slower: float, name: str) -> int:
    """Return how many steps of the physics one of something slower takes.

    Raises:
        ParameterError: If that is no whole number.
    """
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
    """Return so many numbers as an array of their own; refuse what is not finite."""
    numbers = np.array(values, dtype=float)
    if numbers.shape != (n,) or not np.isfinite(numbers).all():
        raise ParameterError(f"{name} of this person must be {n} finite numbers in one row")
    return numbers
