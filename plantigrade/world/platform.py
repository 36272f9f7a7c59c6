"""Moving ground: a heavy plate on joints that tracks a path, with the friction of the floor.

The plate has joints because MuJoCo's mocap bodies have no velocity in contacts and would not carry
a person along.
"""

from abc import abstractmethod
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion.blends import cubic_rise
from plantigrade.world.disturbance import MAX_ANGLE, MAX_TIME, Disturbance, parse_numbers
from plantigrade.world.simulated_world import SimulatedWorld

PLATE_MASS = 2e4  # [kg], and inertia [kg m²] of the plate: feet cannot move it
HALF_THICKNESS = 0.2  # [m] of the plate
HALF_LENGTH = 10.0  # [m] of the plate, and its half width
TRACKING_RATE = 60.0  # [rad/s] of the critically damped return to the path
PLATFORM_JOINTS = ("platform_x", "platform_y", "platform_pitch", "platform_roll")


class Platform(Disturbance):
    """A moving level floor; a subclass defines its position over time.

    Attributes:
        half: Half length and half width of the plate [m].
    """

    interval = 0.005
    half = HALF_LENGTH

    @abstractmethod
    def position(self, time: float) -> Float[Array, " 4"]:
        """Return shift forward and left [m] and tilt up in front and on the left [rad]."""

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Replace the floor by a plate on joints.

        Raises:
            ParameterError: If the ground is not level, or there are two platforms.
        """
        floor = next((g for g in spec.worldbody.geoms if g.name == "floor"), None)
        others = [g.name for g in spec.worldbody.geoms if g.name.startswith(("bump", "relief"))]
        if floor is None or floor.type != mujoco.mjtGeom.mjGEOM_PLANE or others:
            raise ParameterError("moving ground must be level, and there can be only one")
        body = spec.worldbody.add_body(name="platform", gravcomp=1.0)
        body.mass, body.ipos, body.inertia = PLATE_MASS, [0.0, 0.0, 0.0], [PLATE_MASS] * 3
        body.explicitinertial = True
        slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
        for name, kind, axis in zip(
            PLATFORM_JOINTS,
            (slide, slide, hinge, hinge),
            ([1, 0, 0], [0, 1, 0], [0, -1, 0], [1, 0, 0]),
            strict=True,
        ):
            body.add_joint(name=name, type=kind, axis=axis)
        body.add_geom(
            name="floor_plate",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[self.half, self.half, HALF_THICKNESS],
            pos=[0.0, 0.0, float(floor.pos[2]) - HALF_THICKNESS],
            contype=0,
            conaffinity=floor.conaffinity,
            condim=floor.condim,
            friction=floor.friction,
            solref=floor.solref,
            rgba=floor.rgba,
        )
        spec.delete(floor)

    def reset(self, world: SimulatedWorld) -> None:
        """Move the plate to the start of its path."""
        if world.ground != Ground(friction=world.ground.friction):
            raise ParameterError("moving ground must be level, at height zero, without a seat")
        first = world.model.joint(PLATFORM_JOINTS[0])
        world.memory[self] = int(first.qposadr[0]), int(first.dofadr[0])
        q, v = world.memory[self]
        world.data.qpos[q : q + 4], world.data.qvel[v : v + 4], _ = self.path(0.0)

    def act(self, world: SimulatedWorld) -> None:
        """Track the path by its acceleration and a feedback of position and velocity errors."""
        q, v = world.memory[self]
        data = world.data
        place, speed, acceleration = self.path(world.time)
        position_error, velocity_error = place - data.qpos[q : q + 4], speed - data.qvel[v : v + 4]
        desired = (
            acceleration + TRACKING_RATE**2 * position_error + 2 * TRACKING_RATE * velocity_error
        )
        data.qfrc_applied[v : v + 4] = PLATE_MASS * desired
        world.record_signal("ground.place", data.qpos[q : q + 4].copy())

    def path(self, time: float) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration, by finite differences."""
        h = 1e-3
        before, now, after = (self.position(time + k * h) for k in (-1, 0, 1))
        return now, (after - before) / (2 * h), (after - 2 * now + before) / h**2


@dataclass(frozen=True, kw_only=True)
class Tilting(Platform):
    """A plate that tilts back and forth about the start position of the person.

    Attributes:
        amplitude: Maximum tilt [rad].
        period: Period of the oscillation [s].
        direction: Side that rises first, 0 in front, a quarter turn on the left [rad].

    Raises:
        ParameterError: If the tilt is not below 45°, the period is shorter than 0.1 s, or a number
            is not finite.
    """

    amplitude: float
    period: float = 4.0
    direction: float = 0.0

    def __post_init__(self):
        sways = abs(self.amplitude) < np.pi / 4 and 0.1 <= self.period < np.inf
        if not (sways and np.isfinite(self.direction)):
            raise ParameterError(
                f"a plate tilts by less than 45° with a period of at least 0.1 s in a finite "
                f"direction, not {np.rad2deg(self.amplitude):g}° with {self.period:g} s in "
                f"direction {np.rad2deg(self.direction):g}°"
            )

    def position(self, time: float) -> Float[Array, " 4"]:
        """Return a sine whose amplitude increases during the first period."""
        size = self.amplitude * cubic_rise(time / self.period)
        tilt = size * np.sin(2 * np.pi * max(time, 0.0) / self.period)
        return np.array([0.0, 0.0, tilt * np.cos(self.direction), tilt * np.sin(self.direction)])


@dataclass(frozen=True, kw_only=True)
class FloorShift(Platform):
    """A floor that suddenly shifts and stays there.

    Attributes:
        distance: Distance of the shift [m].
        duration: Duration of the shift [s].
        direction: Direction of the shift, 0 forward, a quarter turn to the left [rad].
        time: Start time [s].

    Raises:
        ParameterError: If a number is out of range.
    """

    distance: float
    duration: float = 0.2
    direction: float = 0.0
    time: float = 1.0

    def __post_init__(self):
        number("distance", self.distance, -HALF_LENGTH / 2, HALF_LENGTH / 2, "m", "a shift")
        number("duration", self.duration, 0.02, MAX_TIME, "s", "a shift")
        number("direction", self.direction, -MAX_ANGLE, MAX_ANGLE, "rad", "a shift")
        number("time", self.time, 0, MAX_TIME, "s", "a shift")

    @staticmethod
    def parse(word: str) -> "FloorShift":
        """Return the shift of a text: distance [m], duration [s], direction [°], time [s].

        Raises:
            ParameterError: If the text has another form.

        Example:
            >>> FloorShift.parse("0.1,0.2,180,1").distance
            0.1
        """
        form = "METRES,SECONDS,DIRECTION_DEG,AT_S such as 0.1,0.2,180,1, back after 1 s"
        distance, lasts, direction, at = parse_numbers(word, "shift", form, 4)
        turned = float(np.deg2rad(direction))
        return FloorShift(distance=distance, duration=lasts, direction=turned, time=at)

    def edges(self) -> tuple[float, ...]:
        """Return the start and end time [s]."""
        return (self.time, self.time + self.duration)

    def position(self, time: float) -> Float[Array, " 4"]:
        """Return the position on a minimum-jerk path."""
        u = float(np.clip((time - self.time) / self.duration, 0.0, 1.0))
        path = self.distance * u**3 * (10 - 15 * u + 6 * u * u)
        return np.array([path * np.cos(self.direction), path * np.sin(self.direction), 0.0, 0.0])
