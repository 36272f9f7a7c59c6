"""A walk that is led: how fast, which way, when it stops, and when it goes on."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.balance import Balance
from plantigrade.control.gait.support import beyond
from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.frame import Frame, Seen, Underfoot
from plantigrade.control.pendulum.manner import DEEPEST, Manner, barriers_of, stoop
from plantigrade.control.pendulum.route import Points, Timed, Way, toward
from plantigrade.control.pendulum.settling import Settling
from plantigrade.control.pendulum.styles import RECORDED, Style, Styles
from plantigrade.control.pendulum.turn import Turn
from plantigrade.control.pendulum.words import led_told, switched_told
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.world import Command, Drawing, State, Target, World, standing_on

MOST = 1.3
"""Longest steps, by the recorded ones."""
SPEEDING = 0.5
"""A walk is made faster or slower by so much [m/s²]."""
BOWING = 0.25
"""The head is lowered and raised so fast [m/s]."""
REGAIN, CORRECTED = 0.08, 0.25
"""A speed that is missed is made up for at this rate [1/s], by so much of the steps at most."""
STEADY = 2.5
"""So long after a change of speed the mean speed is believed [s]."""
MEAN = 1.2
"""Time constant of the mean speed: about a stride [s]."""
SLOW = 0.35
"""Of steps shorter than this, by the recorded ones, the mean speed is not believed."""
SHORTEST, WITHIN, STRAIGHT = 0.25, 0.02, 0.05
"""Who steps no longer than this, by the recorded steps, may come to stand: once the extrapolated
centre of mass is so far inside of what both feet span [m], and the walk turns no faster [rad/s]."""
NEAR, LEANING = 0.005, 1.5
"""Who starts brings the extrapolated centre of mass so near to where the walk has it [m], or tries
for so long [s]."""
HASTY = 2.0
"""Who is so many times as fast as the turn to their way allows goes straight on until they are not:
they would turn on a wide bend beside it."""
SAME = 1e-6
"""Speeds nearer than this are one [m/s]."""
PASSED = 0.6
"""Who stoops under a barrier is down so far before it, and rises so far behind it [m]."""
LOW = 0.01
"""What is so near the ground carries then [m]."""


@dataclass(frozen=True, kw_only=True)
class Wish:
    """What a walk is to be.

    Attributes:
        speed: How fast [m/s]; as recorded if absent.
        way: Where to; straight on if absent.
        stoop: How much lower the head is than recorded [cm]; not at all if absent.
        own: What the walk itself is called.
        walks: Other walks of the same person, and when they are taken.
        uppers: What spine, neck and arms do instead, and from when on.
    """

    speed: Timed | None = None
    way: Way | None = None
    stoop: Timed | None = None
    own: str = RECORDED
    walks: tuple[Style, ...] = ()
    uppers: tuple[Style, ...] = ()

    @property
    def leads(self) -> bool:
        """Whether the walk is to be otherwise than recorded."""
        words = (self.speed, self.way, self.stoop)
        timed = any(style.time is not None for style in self.uppers)
        return timed or bool(self.walks) or any(word is not None for word in words)

    @property
    def changes(self) -> tuple[tuple[str, float], ...]:
        """What changes, and when [s]; of speeds, bearings and stoops the last."""
        kept = {"a speed": self.speed, "a bearing": self.way, "a stoop": self.stoop}
        found = [(name, max(kind.times)) for name, kind in kept.items() if kind is not None]
        styles = (("another walk", self.walks), ("another upper body", self.uppers))
        return (*found, *((name, s.time) for name, own in styles for s in own if s.time))


class Walker:
    """Walk as recorded at a wanted speed along a wanted way; stand where it is zero.

    The pendulum walks along x; it is shown the world in a frame that turns and goes with the way.

    Args:
        record: The walk; :class:`~plantigrade.control.pendulum.controller.Pendulum` has the rest.
        wish: What it is to be.
        law: By which feet land.

    Attributes:
        targets: Speed, heading and stoop, and the walk and the upper body where there are several,
            to be set while it walks.
        walks: Whether it walks; else it stands.

    Raises:
        ParameterError: As the pendulum does; or if the walk is too slow for the speed, or has no
            stride that could be repeated.
    """

    rate, control_rate = Pendulum.rate, Pendulum.control_rate
    record_rate = Pendulum.record_rate

    def __init__(self, record: Record, wish: Wish | None = None, law: str = "divergent"):
        self.pendulum = Pendulum(record, law)
        self.record, self.wish, self.lasts = record, wish or Wish(), self.pendulum.lasts
        paced = self.pendulum.reference
        self._own = paced.speed
        if self.wish.leads and paced.period is None:
            raise ParameterError(
                "speed and path are those of a walk that is repeated; no stride of this one is"
            )
        wished = self.wish
        self.styles = Styles(self.pendulum, wished.own, wished.walks, wished.uppers)
        most = MOST * max(self._own, self.styles.fastest, 0.1)
        asked = () if self.wish.speed is None else self.wish.speed.values
        if asked and max(asked) > most:
            raise ParameterError(
                f"speed={max(asked):g} m/s is more than {most:.2f} m/s, {MOST:g} times that of "
                "the recording: name a faster walk"
            )
        self.targets = (
            Target("speed", 0.0, most, min(max(self._own, 0.0), most), "m/s"),
            Target("heading", -180.0, 180.0, 0.0, "deg"),
            Target("stoop", 0.0, DEEPEST, 0.0, "cm"),
            *self.styles.targets,
        )
        self.walks, self._world, self._balance = True, None, Balance()

    def starts(self, qvel: Float[Array, " nv"]) -> Float[Array, " nv"]:
        """Return the velocities with which the walk starts, given those of its first frame."""
        return self.pendulum.starts(qvel)

    def follow(self, points: Float[Array, "n 2"]) -> None:
        """Walk from point to point, and stand at the last.

        Args:
            points: The points, world; without the start [m].
        """
        way = Points(tuple((float(x), float(y)) for x, y in points))
        self.wish = replace(self.wish, way=way)

    def said(self) -> tuple[str, ...]:
        """Return what it did in the last simulation, one sentence each."""
        if self._world is None:
            return ()
        wish = self.wish
        speed = None if wish.speed is None else (self.targets[0].value, self._mean)
        astray = None if wish.way is None else self._astray
        switched = switched_told(self.styles.switched, self.styles.off)
        led = led_told(speed, astray, self._stood, wish.way)
        return (*self.pendulum.said(), *switched, *led)

    def figures(self) -> dict[str, float]:
        """Return figures of the last simulation."""
        figures = self.pendulum.figures()
        if self._world is not None and self.wish.leads:
            figures["speed_wanted_m_s"] = self.targets[0].value
            figures["speed_at_end_m_s"] = self._mean if self.walks else 0.0
            if self.wish.way is not None:
                figures["astray_max_m"] = self._astray
            if isinstance(self.wish.way, Points):
                figures["points_passed"] = self.wish.way.passed
            figures["stood_s"] = sum(end - start for start, end in self._stood)
        if self._world is not None and self.styles.switched:
            figures["switched_s"] = self.styles.switched[-1].time
            figures["off_after_switch_deg"] = float(np.rad2deg(self.styles.off))
        return figures

    def drawings(self, state: State) -> tuple[Drawing, ...]:
        """Return the pendulum and where the swinging foot is to land; what balance has."""
        if self._world is not state.world:
            return ()
        if not self.walks:
            return self._balance.drawings(state)
        drawn = self.pendulum.drawings(self._seen(state))
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
        """Return what the joints are to do for one control step."""
        if self._world is not state.world or (state.time == 0.0 and self._time > 0.0):
            self._begin(state)
        self._time = state.time
        self._ask(state.time)
        self.styles.look(state.time, self.walks)
        if self.walks and self._may_stand(state):
            self._stop(state)
        elif not self.walks and self.targets[0].value > 0.0:
            self._lean(state)
        if not self.walks:
            self._stood[-1] = (self._stood[-1][0], state.time)
            return self._balance(state)
        pendulum, frame, step = self.pendulum, self.frame, 1.0 / state.world.control_rate
        self._steer(step)
        self._pace(step)
        self._duck()
        self._bow(step)
        if self._ground.moves or not frame.is_world:
            pendulum.ground, pendulum.normal = self._ground, self._ground.normal
        command = pendulum(self._seen(state))
        self.styles.count(float(command.signals["tracking_error"]))
        if frame.is_world:
            return command
        place = np.append(command.signals["landing"], 0.0)
        return replace(command, signals={**command.signals, "landing": frame.to_world(place)[:2]})

    def _begin(self, state: State) -> None:
        """Start anew."""
        self._world: World | None = state.world
        self.frame = Frame()
        self.styles.begin()
        self.pendulum.reference.start(1.0, 0.0, 0.0)
        self.pendulum.begin(state)
        self._turn = Turn()
        self.pendulum.plan.heading = self._turn.after
        self._ground = Underfoot(state.world, self.frame)
        self.walks, self._time = True, 0.0
        self._stride, self._mean, self._more = 1.0, self._own, 0.0
        self._last = float(self.pendulum.place[0])
        self._asked = self._way = self._stooping = np.nan
        self._depth, self._deepest = 0.0, stoop(state.human, 0.01 * DEEPEST)
        self.pendulum.reference.manner = None
        self._ducked = 0.0
        self._barriers = barriers_of(state.world)
        self._fastest = np.inf
        self._deep = 0.01 * max((depth for _, depth in self._barriers), default=0.0)
        self._steady, self._since = 0.0, None
        self._aside = self._astray = 0.0
        self._stood: list[tuple[float, float]] = []

    def _seen(self, state: State) -> State:
        """Return the state as the pendulum sees it."""
        return state if self.frame.is_world else Seen(state, self.frame)

    def _ask(self, time: float) -> None:
        """Set the targets to what is wanted now, where that is another than before."""
        speed, heading, low = self.targets[:3]
        if self.wish.stoop is not None:
            asked = self.wish.stoop.at(time)
            if asked != self._stooping:
                self._stooping = asked
                low.set(asked)
        if self.wish.speed is not None:
            asked = self.wish.speed.at(time)
            if asked != self._asked:
                self._asked = asked
                speed.set(asked)
        if self.wish.way is not None:
            x, y = self.frame.to_world(np.array([*self._here, 0.0]))[:2].tolist()
            way = self.wish.way.bearing(time, x, y)
            self._fastest = self.wish.way.fastest(x, y, self.frame.angle)
            if way is None:
                speed.set(0.0)
            elif way != self._way:
                self._way = way
                heading.set(float(np.rad2deg(toward(way, 0.0))))

    @property
    def _here(self) -> tuple[float, float]:
        """Where on their line the walker is, in the frame [m]."""
        return float(self.pendulum.place[0]), float(self.pendulum.plan.path[1])

    def _duck(self) -> None:
        """Stoop where a barrier is near, deep enough to pass under it."""
        if self.wish.stoop is not None or not self._barriers:
            return
        place = np.array([*self.pendulum.place, 0.0])
        x = float(self.frame.to_world(place)[0])
        before = PASSED + self._mean * self._deep / BOWING
        near = [d for at, d in self._barriers if at - before < x < at + PASSED]
        deep = max(near, default=0.0)
        if deep != self._ducked:
            self._ducked = deep
            self.targets[2].set(deep)

    def _bow(self, step: float) -> None:
        """Stoop, or rise again."""
        wanted = 0.01 * self.targets[2].value
        if wanted == self._depth:
            return
        far = BOWING * step
        self._depth += min(max(wanted - self._depth, -far), far)
        whole = self._deepest
        part = 100.0 * self._depth / DEEPEST
        self.pendulum.reference.manner = (
            Manner(part * whole.lowered, part * whole.angles) if self._depth > 0.0 else None
        )

    def _steer(self, step: float) -> None:
        """Turn the frame to the bearing that is wanted."""
        off = float(self.pendulum.place[1]) - self._here[1]
        self._aside += step / MEAN * (off - self._aside)
        self._astray = max(self._astray, self._beside())
        off = toward(float(np.deg2rad(self.targets[1].value)), self.frame.angle)
        if self._mean > HASTY * self._fastest:
            off = 0.0
        paced, turn = self.pendulum.reference, self._turn
        steps = self.pendulum.gait.reference.duration / paced.cadence
        turn.look(off, self._mean, 0.5 * steps, paced.omega, step)
        self.pendulum.plan.turning = turn.rate
        if turn.rate != 0.0:
            self.frame.steer(*self._here, step * turn.rate)

    def _beside(self) -> float:
        """Return how far the walker is from the way, over a stride [m]."""
        ahead, left = self._here
        if self.wish.way is not None:
            x, y = self.frame.to_world(np.array([ahead, left + self._aside, 0.0]))[:2]
            off = self.wish.way.off(float(x), float(y))
            if off is not None:
                return off
        return abs(self._aside)

    def _pace(self, step: float) -> None:
        """Make steps longer or shorter, to the speed that is wanted."""
        paced = self.pendulum.reference
        crossing, phase = paced.crossing, self.pendulum.gait.phase
        own = paced.speed * (1.0 if crossing is None else crossing.mean_cadence)
        own = max(own, 1e-3)
        if abs(self.targets[0].value - self._own) < SAME:  # as fast as the walk itself is
            self.targets[0].set(min(own, self.targets[0].high))
        self._own, wanted = own, min(self.targets[0].value, self._fastest)
        ahead = float(self.pendulum.place[0])
        self._mean += step / MEAN * ((ahead - self._last) / step - self._mean)
        self._last = ahead
        aim, far = min(wanted / own, MOST), SPEEDING / own * step
        self._stride += min(max(aim - self._stride, -far), far)
        self._steady = self._steady + step if self._stride == aim else 0.0
        if self._steady > STEADY and aim > SLOW:
            self._more += step * REGAIN * (wanted - self._mean) / own
            self._more = min(max(self._more, -CORRECTED), CORRECTED)
        more = self._more * min(self._stride / SLOW, 1.0)
        cadence = 1.0 if crossing is None else crossing.cadence(phase)
        paced.set(min(self._stride + more, MOST), cadence, phase)

    def _may_stand(self, state: State) -> bool:
        """Return whether balance could take over now, and should."""
        if self.targets[0].value > 0.0 or self._stride > SHORTEST:
            return False
        if abs(self._turn.rate) > STRAIGHT:
            return False
        if len(self.pendulum.gait.standing) < len(SIDES):
            return False
        body = self._seen(state).body
        xi = (body.com + body.com_velocity / self.pendulum.reference.omega)[:2]
        low, height = self.pendulum.low, self.pendulum.height
        return beyond(low[height < LOW, :2], xi) < -WITHIN

    def _stop(self, state: State) -> None:
        """Hand over to balance."""
        world, human = state.world, state.human
        self.walks = False
        self._stood.append((state.time, state.time))
        if self._ground.moves:
            self._balance = Balance(stepping=True)
            return
        feet = self.frame.to_world(self.pendulum.low)
        x, y = feet.mean(axis=0)[:2]
        place = (float(x), float(y), self.frame.angle)
        stands = standing_on(human, world.ground, place=place)
        self._balance = Balance(Settling(human, state.qpos, stands, state.time), stepping=True)

    def _lean(self, state: State) -> None:
        """Bring the weight over the foot that is to stand first; then walk, in place at first."""
        pendulum, paced = self.pendulum, self.pendulum.reference
        body = self._seen(state).body
        feet = body.origins[pendulum.feet]
        if self._since is None:
            self._since, self._from = state.time, self._lift(float(feet[0, 0] - feet[1, 0]))
        phase, stands, off = self._from
        goal = float(feet[stands, 1]) + off
        xi = float((body.com + body.com_velocity / paced.omega)[1])
        toward_it = 1.0 if stands else -1.0
        if (goal - xi) * toward_it > NEAR and state.time - self._since < LEANING:
            middle = float(feet[:, 1].mean())
            way = 100.0 * (goal - middle) * self.frame.turn[:2, 1]
            for target, far in zip(self._balance.targets[:2], way, strict=True):
                target.set(min(max(float(far), target.low), target.high))
            return
        ahead, left = feet[:, :2].mean(axis=0)
        paced.start(0.0, phase, float(ahead))
        now = paced.at(phase)["foot"][stands, 1]
        self.frame.shift(float(feet[stands, 1] - now))
        pendulum.place = np.array([ahead, 0.0])
        pendulum.resume(self._seen(state).body, phase)
        self._turn = Turn()
        pendulum.plan.heading = self._turn.after
        self.walks, self._since = True, None
        self._stride = self._mean = self._more = 0.0
        self._last = float(ahead)

    def _lift(self, ahead: float) -> tuple[float, int, float]:
        """Return with what the recording a walk begins: a foot is about to leave the ground.

        Args:
            ahead: How far the right foot is in front of the left one [m]; that stays on.

        Returns:
            The phase [s]; which foot stands; how far the extrapolated centre of mass is then to the
            left of it [m].
        """
        recorded = self.pendulum.reference.recorded
        stands = 0 if ahead >= 0.0 else 1
        times = np.arange(0.0, recorded.duration, 0.01)
        both = [
            all(recorded.schedule.standing(side, float(t)) is not None for side in SIDES)
            for t in times
        ]
        front = [recorded.at(float(t))["foot"][:, 0] for t in times]
        ends = [
            k
            for k in range(len(times))
            if both[k] and not both[(k + 1) % len(times)] and front[k].argmax() == stands
        ]
        phase = float(times[ends[0]]) if ends else 0.0
        now = recorded.at(phase)
        xi = now["com"] + now["com_velocity"] / recorded.omega
        return phase, stands, float(xi[1] - now["foot"][stands, 1])
