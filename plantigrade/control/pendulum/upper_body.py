"""Spine, neck and arms of another motion, on the legs of a walk.

The upper body is that of another walk, in step with the legs; of another motion, in its own time;
or a pose. From a recording the lean of the trunk in the world is taken, not its angle against the
pelvis, which the markers of each person tilt differently.

The mass stays over the feet where the walk has it: the pelvis goes back under a trunk that leans
forward. It is as much lower as such a posture has it, and as legs need to reach as far as before
from hips farther back.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.person import leg_length
from plantigrade.control.gait.reference import ReferenceTables
from plantigrade.control.pendulum.speed import SpeedSettings
from plantigrade.control.pendulum.transition import PhaseMap
from plantigrade.errors import ParameterError, known_names
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.motion.blends import cubic_rise

SPINE = "lumbar_extension"  # takes up the different tilt of the pelvis
N_INSTANTS = 12  # of a stride, by which the mean height of the mass is found
LEGS = ("femur", "patella", "tibia", "talus", "foot", "heel", "toes", "medial", "lateral")
"""Beginnings of the names of bodies of the legs."""


def upper_hinges(human: Human) -> Bool[Array, " n_hinges"]:
    """Return which hinges are of spine, neck and arms."""
    model = human.model
    moved = [human.body_names[int(b) - 1] for b in model.jnt_bodyid[1:]]
    return np.array([not name.startswith(LEGS) for name in moved])


def _arms(flex: float, add: float, elbow: float) -> dict[str, float]:
    """Return angles of both arms, alike [deg]."""
    one = {"arm_flex": flex, "arm_add": add, "arm_rot": 0.0, "elbow_flex": elbow}
    return {f"{name}_{side}": angle for side in SIDES for name, angle in one.items()}


POSES: Mapping[str, Mapping[str, float]] = {
    "arms-forward": _arms(80, -8, 10),
    "arms-out": _arms(0, -70, 10),
    "arms-up": _arms(150, -8, 20),
    "leaning": {"lumbar_extension": -10, "lumbar_bending": 0, "neck_extension": 5},
}
"""Poses by name: coordinate → angle [deg]; at 0 arms hang, and trunk and pelvis are in line."""


@dataclass(frozen=True, eq=False)
class FixedPose:
    """Angles of some hinges; the others stay as recorded."""

    hinges: Bool[Array, " n_hinges"]  #: Which
    angles: Float[Array, " n_posed"]  #: Their angles [rad]

    @classmethod
    def of(cls, human: Human, angles: Mapping[str, float]) -> "FixedPose":
        """Return the pose of coordinates.

        Args:
            angles: Coordinate of spine, neck or arms → angle [rad].
        """
        upper, names = upper_hinges(human), human.coordinates
        free = [name for name, own in zip(names, upper, strict=True) if own]
        hinges, values = np.zeros(len(names), dtype=bool), np.zeros(len(names))
        for name, angle in angles.items():
            if name not in free:
                raise ParameterError(
                    f"no coordinate {name!r} of the upper body; {known_names(name, free)}"
                )
            i = names.index(name)
            low, high = np.rad2deg(human.model.jnt_range[i + 1]).tolist()
            if not low <= np.rad2deg(angle) <= high:
                raise ParameterError(f"{name}={np.rad2deg(angle):g}° must be {low:.0f}–{high:.0f}°")
            hinges[i], values[i] = True, angle
        return cls(hinges, values[hinges])

    def apply(self, instant: Instant, phase: float, time: float, cadence: float) -> None:
        """Apply it to an instant of a walk."""
        hinges = self.hinges
        instant.q[7:][hinges] = self.angles
        instant.v[6:][hinges] = instant.a[6:][hinges] = 0.0


@dataclass(frozen=True, eq=False)
class UpperMotion:
    """The upper body of another motion, in step with the legs or in its own time."""

    #: That motion; in its own time it ends in its last posture, unless it is repeated
    motion: ReferenceTables
    hinges: Bool[Array, " n_hinges"]  #: Which are taken from it
    offset: Float[Array, " n_upper"]  #: Added to their angles [rad]
    start: float  #: When it begins [s]
    phases: PhaseMap | None  #: From the walk of the legs to a walk in step with it; else None

    def apply(self, instant: Instant, phase: float, time: float, cadence: float) -> None:
        """Apply it to an instant of a walk."""
        hinges = self.hinges
        if self.phases is not None:
            other, rate = self.motion.at(self.phases.to_old(phase)), self.phases.rate(phase)
            rate = cadence * rate
        else:
            since = time - self.start
            other, rate = self.motion.at(max(since, 0.0)), 1.0
            if self.motion.period is None and since >= self.motion.duration:
                other = other.still()
        instant.q[7:][hinges] = other.q[7:][hinges] + self.offset
        instant.v[6:][hinges] = rate * other.v[6:][hinges]
        instant.a[6:][hinges] = rate**2 * other.a[6:][hinges]


Source = FixedPose | UpperMotion


def source_of(
    human: Human, other: ReferenceTables | FixedPose, walk: ReferenceTables, time: float
) -> Source:
    """Return an upper body for the legs of a walk.

    Args:
        other: The other walk or motion of the same person, or a pose.
        time: When it begins [s].
    """
    if isinstance(other, FixedPose):
        return other
    hinges, offset = upper_hinges(human), np.zeros(len(human.coordinates))
    if SPINE in human.coordinates:
        offset[human.hinge(SPINE)] = tilt_of(human, other) - tilt_of(human, walk)
    try:
        phases = PhaseMap(walk.schedule, other.schedule, lifts=False)
    except ParameterError:  # no walk, or none whose strides can be compared
        phases = None
    return UpperMotion(other, hinges, offset[hinges], time, phases)


def tilt_of(human: Human, walk: ReferenceTables) -> float:
    """Return the mean tilt of the pelvis, backward [rad]."""
    names, values = human.to_coordinates(walk.rows.q)
    return float(np.mean(values[:, names.index("pelvis_tilt")]))


def lowering(human: Human, walk: ReferenceTables, source: Source | None, time: float) -> float:
    """Return the lowering of the mass by another upper body [m].

    Args:
        source: Motion of the upper body; None: as recorded.
        time: When it begins [s].
    """
    if source is None:
        return 0.0
    body, moved = BodyState(human, human.standing()), []
    leg = leg_length(human)
    for part in np.arange(N_INSTANTS) / N_INSTANTS:
        phase = float(part) * walk.duration
        instant = walk.at(phase)
        before = body.moved_to(np.array(instant.q)).com
        source.apply(instant, phase, time + phase, 1.0)
        moved.append(body.moved_to(np.array(instant.q)).com - before)
    ahead, _, up = np.mean(moved, axis=0).tolist()
    half = 0.25 * float(np.linalg.norm(walk.advance))  # of a step
    return abs(ahead) * half / leg - up


class BlendedUpperBody:
    """The upper body of a walk, blended with the one before.

    Args:
        source: Its motion; None: as recorded.
        since: When it changed [s].

    Attributes:
        time: Now [s].
    """

    def __init__(
        self,
        human: Human,
        walk: ReferenceTables,
        source: Source | None,
        before: Source | None,
        since: float,
        settings: SpeedSettings | None = None,
    ):
        self.settings = settings or SpeedSettings()
        self.source, self.before, self.since = source, before, since
        self.time = since
        self._lower = [lowering(human, walk, each, since) for each in (before, source)]

    @property
    def part(self) -> float:
        """Weight of the new one, from 0 to 1."""
        return float(cubic_rise((self.time - self.since) / self.settings.stride_time))

    def apply(self, instant: Instant, phase: float, cadence: float) -> None:
        """Apply it to an instant of a walk.

        Args:
            instant: The instant, which is changed.
            phase: Phase of the walk [s].
            cadence: Steps in a time, by those of the walk.
        """
        part = self.part
        lower = (1.0 - part) * self._lower[0] + part * self._lower[1]
        instant.com[2] -= lower
        instant.q[2] -= lower
        cuts = [instant.q[7:], instant.v[6:], instant.a[6:]]
        recorded = [np.array(cut) for cut in cuts] if part < 1.0 else []
        if part < 1.0 and self.before is not None:
            self.before.apply(instant, phase, self.time, cadence)
        old = [np.array(cut) for cut in cuts] if part < 1.0 else []
        for cut, own in zip(cuts, recorded, strict=False):
            cut[:] = own
        if self.source is not None:
            self.source.apply(instant, phase, self.time, cadence)
        for cut, own in zip(cuts, old, strict=False):
            cut *= part
            cut += (1.0 - part) * own
