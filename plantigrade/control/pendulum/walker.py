"""A commanded walk: its speed and path, its stops, and what follows them."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.balance import Balance
from plantigrade.control.gait.support import beyond
from plantigrade.control.pendulum.command import WalkCommand
from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.crouch import CrouchControl
from plantigrade.control.pendulum.frame import HeadingFrame, ObservedState, Terrain
from plantigrade.control.pendulum.path import Waypoints, angle_to
from plantigrade.control.pendulum.settings import PendulumSettings
from plantigrade.control.pendulum.speed import SpeedControl
from plantigrade.control.pendulum.standing import GaitStart, Settling
from plantigrade.control.pendulum.styles import Styles
from plantigrade.control.pendulum.summary import command_summary, style_summary
from plantigrade.control.pendulum.turn import Turn
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.world import (
    Command,
    Controller,
    Drawing,
    InitialState,
    SimulatedWorld,
    State,
    Summary,
    Target,
    standing_on,
)

SPEED_TOLERANCE = 1e-6  # [m/s] speeds nearer than this are one
MIN_SPEED = 0.1  # [m/s] counted for a walk in place, whose targets would have no range


class Walker(Controller):
    """Walk as recorded at a commanded speed along a commanded path; stand where it is zero.

    The pendulum walks along x; it is shown the world in a frame that turns and goes with the path.

    Args:
        record: The walk; :class:`~plantigrade.control.pendulum.controller.Pendulum` has the rest.
        command: How it is to differ.
        settings: The numbers of the controller.

    Attributes:
        targets: Speed, heading and stoop, and the walk and the upper body where there are several,
            to be set while it walks.
        walking: Whether it walks; else it stands.
        stops: From when to when it stood [s].

    Raises:
        ParameterError: As the pendulum does; or if the walk is too slow for the speed, or has no
            stride that could be repeated.
    """

    rates = Pendulum.rates

    def __init__(
        self,
        record: Record,
        command: WalkCommand | None = None,
        *,
        settings: PendulumSettings | None = None,
    ):
        self.settings = settings or PendulumSettings()
        self.pendulum = Pendulum(record, settings=self.settings)
        self.rates, self.duration = self.pendulum.rates, self.pendulum.duration
        self.record = record
        self.command = command = command or WalkCommand()
        reference = self.pendulum.reference
        self._own = reference.speed
        if command.leads and reference.period is None:
            raise ParameterError(
                "speed and path are those of a walk that is repeated; no stride of this one is"
            )
        self.styles = Styles(self.pendulum, command.own, command.walks, command.uppers)
        scale = self.settings.speed.max_step_scale
        fastest = scale * max(self._own, self.styles.fastest, MIN_SPEED)
        desired = () if command.speed is None else command.speed.values
        if desired and max(desired) > fastest:
            raise ParameterError(
                f"speed={max(desired):g} m/s is more than {fastest:.2f} m/s, {scale:g} times that "
                "of the recording: name a faster walk"
            )
        self.targets = (
            Target("speed", 0.0, fastest, min(max(self._own, 0.0), fastest), "m/s"),
            Target("heading", -180.0, 180.0, 0.0, "deg"),
            Target("stoop", 0.0, self.settings.crouch.max_depth_cm, 0.0, "cm"),
            *self.styles.targets,
        )
        self.walking, self._world, self._balance = True, None, Balance()

    def start(self, initial: InitialState) -> InitialState:
        """Return how the walk starts."""
        return self.pendulum.start(initial)

    def follow(self, points: Float[Array, "n 2"]) -> bool:
        """Walk from point to point, and stand at the last.

        Args:
            points: The points, world; without the start [m].
        """
        path = Waypoints(tuple((float(x), float(y)) for x, y in points), self.settings.path)
        self.command = replace(self.command, path=path)
        return True

    def summary(self) -> Summary:
        """Return speed, path, footsteps and changes of gait of the last simulation."""
        if self._world is None:
            return Summary()
        own, styles, walked = self.command, self.styles, self.pendulum.summary()
        figures, mean = dict(walked.figures), self._speed.mean
        if own.leads:
            figures["speed_wanted_m_s"] = self.targets[0].value
            figures["speed_at_end_m_s"] = mean if self.walking else 0.0
            if own.path is not None:
                figures["astray_max_m"] = self._max_deviation
            if isinstance(own.path, Waypoints):
                figures["points_passed"] = own.path.passed
            figures["stood_s"] = sum(end - start for start, end in self.stops)
        if styles.changes:
            figures["switched_s"] = styles.changes[-1].time
            figures["off_after_switch_deg"] = float(np.rad2deg(styles.error))
        speed = None if own.speed is None else (self.targets[0].value, mean)
        deviation = None if own.path is None else self._max_deviation
        sentences = (
            *walked.sentences,
            *style_summary(styles.changes, styles.error),
            *command_summary(speed, deviation, self.stops, own.path),
        )
        return Summary(sentences, figures)

    @property
    def shared(self) -> tuple[object, ...]:
        """The recorded walk."""
        return (self.record,)

    def drawings(self, state: State) -> tuple[Drawing, ...]:
        """Return the pendulum and the next footstep, or the drawings of balance."""
        if self._world is not state.world:
            return ()
        if not self.walking:
            return self._balance.drawings(state)
        drawn = self.pendulum.drawings(self._observed(state))
        if self.frame.is_world:
            return drawn
        put = self.frame.to_world
        return tuple(
            Drawing(
                name=d.name,
                points=None if d.points is None else put(d.points),
                lines=None if d.lines is None else put(d.lines),
                colour=d.colour,
            )
            for d in drawn
        )

    def __call__(self, state: State) -> Command:
        """Return the command for one control step."""
        if self._world is not state.world or (state.time == 0.0 and self._time > 0.0):
            self._begin(state)
        self._time = state.time
        self._set_targets(state.time)
        self.styles.update(state.time, self.walking)
        if self.walking and self._may_stand(state):
            self._stop(state)
        elif not self.walking and self.targets[0].value > 0.0:
            self._shift_weight(state)
        if not self.walking:
            self.stops[-1] = (self.stops[-1][0], state.time)
            return self._balance(state)
        pendulum, frame, step = self.pendulum, self.frame, 1.0 / state.world.control_rate
        self._turn_frame(step)
        self._set_speed(step)
        pendulum.reference.crouch = self._crouch.update(self._depth(), step)
        if self._ground.moves or not frame.is_world:
            pendulum.ground.replace(self._ground)
        command = pendulum(self._observed(state))
        self.styles.record_error(float(command.signals["tracking_error"]))
        if frame.is_world:
            return command
        place = np.append(command.signals["landing"], 0.0)
        return replace(command, signals={**command.signals, "landing": frame.to_world(place)[:2]})

    def _begin(self, state: State) -> None:
        """Start anew."""
        own, pendulum = self.settings, self.pendulum
        self._world: SimulatedWorld | None = state.world
        self.frame = HeadingFrame()
        self.styles.begin()
        pendulum.reference.start(1.0, 0.0, 0.0)
        pendulum.begin(state)
        self._turn = Turn(own.path.turn)
        pendulum.plan.predicted_turn = self._turn.predicted
        self._ground = Terrain(state.world, self.frame)
        self.walking, self._time = True, 0.0
        self._speed = SpeedControl(own.speed, 1.0, self._own, float(pendulum.position[0]))
        self._crouch = CrouchControl(state.human, state.world, own.crouch)
        pendulum.reference.crouch = None
        if self.command.path is not None:
            self.command = replace(self.command, path=self.command.path.started(own.path))
        self._commanded = [np.nan, np.nan, np.nan]
        self._barrier_depth, self._speed_limit = 0.0, np.inf
        self._since: float | None = None
        self._lateral_error = self._max_deviation = 0.0
        self.stops: list[tuple[float, float]] = []

    def _observed(self, state: State) -> State:
        """Return the state as the pendulum observes it."""
        return state if self.frame.is_world else ObservedState(state, self.frame)

    def _set_targets(self, time: float) -> None:
        """Set the targets to the command, where that has changed."""
        command = self.command
        self._set_target(2, None if command.stoop is None else command.stoop.at(time))
        self._set_target(0, None if command.speed is None else command.speed.at(time))
        if command.path is not None:
            x, y = self.frame.to_world(np.array([*self._here, 0.0]))[:2].tolist()
            heading = command.path.heading(time, x, y)
            self._speed_limit = command.path.speed_limit(x, y, self.frame.angle)
            if heading is None:
                self.targets[0].set(0.0)
            elif heading != self._commanded[1]:
                self._commanded[1] = heading
                self.targets[1].set(float(np.rad2deg(angle_to(heading, 0.0))))

    def _set_target(self, i: int, value: float | None) -> None:
        """Set a target to its command, if that is another than before."""
        if value is not None and value != self._commanded[i]:
            self._commanded[i] = value
            self.targets[i].set(value)

    @property
    def _here(self) -> tuple[float, float]:
        """Position on the line of the walk, in the frame [m]."""
        return float(self.pendulum.position[0]), float(self.pendulum.plan.push.line[1])

    def _depth(self) -> float:
        """Return how deep to crouch [cm]: as the target says, which barriers set."""
        if self.command.stoop is None and self._crouch.barriers:
            x = float(self.frame.to_world(np.array([*self.pendulum.position, 0.0]))[0])
            depth = self._crouch.depth_under_barriers(x, self._speed.mean)
            if depth != self._barrier_depth:
                self._barrier_depth = depth
                self.targets[2].set(depth)
        return self.targets[2].value

    def _turn_frame(self, step: float) -> None:
        """Turn the frame to the desired heading."""
        own, pendulum, speed = self.settings, self.pendulum, self._speed.mean
        error = float(pendulum.position[1]) - self._here[1]
        self._lateral_error += step / own.speed.stride_time * (error - self._lateral_error)
        self._max_deviation = max(self._max_deviation, self._deviation())
        error = angle_to(float(np.deg2rad(self.targets[1].value)), self.frame.angle)
        if speed > own.speed.turn_overspeed * self._speed_limit:
            error = 0.0
        reference, turn = pendulum.reference, self._turn
        stride = pendulum.gait.reference.duration / reference.cadence
        turn.update(error, speed, 0.5 * stride, reference.omega, step)
        pendulum.plan.turn_rate = turn.rate
        if turn.rate != 0.0:
            self.frame.steer(*self._here, step * turn.rate)

    def _deviation(self) -> float:
        """Return the distance from the path, over a stride [m]."""
        ahead, left = self._here
        if self.command.path is not None:
            x, y = self.frame.to_world(np.array([ahead, left + self._lateral_error, 0.0]))[:2]
            deviation = self.command.path.deviation(float(x), float(y))
            if deviation is not None:
                return deviation
        return abs(self._lateral_error)

    def _set_speed(self, step: float) -> None:
        """Make steps longer or shorter, to the desired speed."""
        reference = self.pendulum.reference
        transition, phase = reference.transition, self.pendulum.gait.phase
        own = reference.speed * (1.0 if transition is None else transition.mean_cadence)
        own = max(own, 1e-3)
        if abs(self.targets[0].value - self._own) < SPEED_TOLERANCE:  # as fast as the walk is
            self.targets[0].set(min(own, self.targets[0].high))
        self._own, desired = own, min(self.targets[0].value, self._speed_limit)
        ahead, displaced = float(self.pendulum.position[0]), self.pendulum.plan.push.displaced
        scale = self._speed.update(desired, own, ahead, step, displaced=displaced)
        cadence = 1.0 if transition is None else transition.cadence(phase)
        reference.scale(scale, cadence, phase)

    def _may_stand(self, state: State) -> bool:
        """Return whether balance could take over now, and should."""
        own = self.settings.speed
        if self.targets[0].value > 0.0 or self._speed.scale > own.min_corrected_scale:
            return False
        if len(self.pendulum.gait.stance_feet) < len(SIDES):
            return False
        body = self._observed(state).body
        xi = (body.com + body.com_velocity / self.pendulum.reference.omega)[:2]
        low, height, _ = self.pendulum.soles
        return (
            beyond(low[height < self.settings.gait.contact.max_planned_height, :2], xi)
            < -self.settings.balance.recovery.step.capture_margin  # else balance would step
        )

    def _stop(self, state: State) -> None:
        """Hand over to balance."""
        world, human = state.world, state.human
        self.walking = False
        self.stops.append((state.time, state.time))
        if self._ground.moves:
            self._balance = Balance(settings=self.settings.balance)
            return
        feet = self.frame.to_world(self.pendulum.soles.low)
        x, y = feet.mean(axis=0)[:2]
        place = (float(x), float(y), self.frame.angle)
        stands = standing_on(human, world.ground, placement=place)
        duration = self.settings.speed.weight_shift_time
        settling = Settling(human, state.qpos, stands, state.time, duration)
        self._balance = Balance(settling, settings=self.settings.balance)

    def _shift_weight(self, state: State) -> None:
        """Bring the weight over the first stance foot; then walk, in place at first."""
        pendulum, reference, own = self.pendulum, self.pendulum.reference, self.settings
        body = self._observed(state).body
        feet = body.origins[pendulum.foot_bodies]
        if self._since is None:
            ahead = float(feet[0, 0] - feet[1, 0])
            self._since, self._start = state.time, GaitStart.of(reference.recorded, ahead)
        start, since = self._start, state.time - self._since
        goal = float(feet[start.stance, 1]) + start.lateral_offset
        xi = float((body.com + body.com_velocity / reference.omega)[1])
        left = (goal - xi) * (1.0 if start.stance else -1.0)
        near = left <= own.balance.recovery.step.support_margin
        if not near and since < own.speed.weight_shift_time:
            middle = float(feet[:, 1].mean())
            shift = 100.0 * (goal - middle) * self.frame.turn[:2, 1]
            for target, value in zip(self._balance.targets[:2], shift, strict=True):
                target.set(min(max(float(value), target.low), target.high))
            return
        ahead = float(feet[:, 0].mean())
        reference.start(0.0, start.phase, ahead)
        now = reference.at(start.phase).foot_position[start.stance, 1]
        self.frame.shift(float(feet[start.stance, 1] - now))
        pendulum.position = np.array([ahead, 0.0])
        pendulum.resume(self._observed(state).body, start.phase)
        self._turn = Turn(own.path.turn)
        pendulum.plan.predicted_turn = self._turn.predicted
        self.walking, self._since = True, None
        self._speed = SpeedControl(own.speed, 0.0, 0.0, ahead)
