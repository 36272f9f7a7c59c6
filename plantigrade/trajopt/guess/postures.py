"""Postures that a task starts from, passes or ends in, and a first guess that interpolates them.

A posture is given by the pelvis, trunk and arms; the legs reach for the footprints.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.motion.blends import quintic_rise
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    about_vertical,
    pelvis_angles_to_quaternion,
    rotation_matrix,
)
from plantigrade.trajopt.guess.legs import Leg
from plantigrade.trajopt.problem.contact_body import ContactBody

STRETCHED_TIME = 0.3  # [s] time with extended legs at either end of a guess with flexed legs
MAX_LEG_EXTENSION = 0.999  # [1] maximum leg extension of a guess relative to thigh plus shank


def standing_feet(human: Human) -> dict[str, Footprint]:
    """Return where the feet are in the person's quiet standing at the origin."""
    places = {side: human.skeleton.origins[f"foot_{side}"] for side in SIDES}
    return {s: Footprint(s, (float(p[0]), float(p[1]), 0.0)) for s, p in places.items()}


def standing_stances(feet: Mapping[str, Footprint], duration: float) -> tuple[Stance, ...]:
    """Return feet that stand flat throughout a motion."""
    end = duration + 1.0
    return tuple(Stance(foot, -1.0, -1.0, end, end, end) for foot in feet.values())


def foot_stances(stances: Sequence[Stance], side: str) -> list[Stance]:
    """Return the stances of one foot."""
    own = [s for s in stances if s.footprint.side == side]
    if not own:
        raise ParameterError(f"the {'right' if side == 'r' else 'left'} foot has no stance")
    return own


def body_at(human: Human, q: Float[Array, " nv"]) -> BodyState:
    """Return the body in a posture."""
    return BodyState(human, human.from_coordinates(PELVIS + human.coordinates, q[None])[0])


def standing_posture(human: Human) -> Float[Array, " nv"]:
    """Return the coordinates of quiet standing at the origin."""
    return human.to_coordinates(human.standing()[None])[1][0]


def standing_on(human: Human, feet: Mapping[str, Footprint]) -> Float[Array, " nv"]:
    """Return the coordinates of quiet standing at the origin, on other footprints near its own."""
    there = {s: (_ankle(human, foot), foot.heading) for s, foot in feet.items()}
    return reaching(human, standing_posture(human)[None], there)[0]


def with_limbs(
    human: Human, q: Float[Array, " nv"], limbs: Mapping[str, Mapping[str, float]]
) -> Float[Array, " nv"]:
    """Return a posture with other angles of limbs, by side; those that a person has."""
    out = q.copy()
    for side, angles in limbs.items():
        for name, angle in angles.items():
            if f"{name}_{side}" in human.coordinates:
                out[6 + human.hinge(f"{name}_{side}")] = angle
    return out


def standing_hinges(human: Human, n: int) -> Float[Array, "n n_hinges"]:
    """Return the hinges of quiet standing, n times [rad]."""
    return np.tile(standing_posture(human)[6:], (n, 1))


def posture(
    human: Human,
    feet: Mapping[str, Footprint],
    *,
    hip: tuple[float, float],
    tilt: float = 0.0,
    joints: Mapping[str, float] | None = None,
) -> Float[Array, " nv"]:
    """Return the coordinates of a posture on both feet, or as near to it as the legs reach.

    Args:
        feet: Where the feet stand.
        hip: Middle of the hip joints: forward and up, world [m].
        tilt: Tilt of the pelvis, backwards positive as in OpenSim [rad].
        joints: Hinges of trunk and arms by name [rad]; those of standing if not given.
    """
    q = standing_posture(human)
    for name, value in (joints or {}).items():
        q[6 + human.hinge(name)] = value
    q[:3] = tilt, 0.0, 0.0
    R = rotation_matrix(pelvis_angles_to_quaternion(q[None, :3]))[0]
    between_hips = Leg(human, "r").hip * [1.0, 0.0, 1.0]
    q[3:6] = (np.array([hip[0], 0.0, hip[1]]) - R @ between_hips) @ OPENSIM_TO_WORLD
    return reaching(human, q[None], {s: (_ankle(human, f), f.heading) for s, f in feet.items()})[0]


def _ankle(human: Human, foot: Footprint) -> Float[Array, " 3"]:
    return np.array(foot.position) + [0.0, 0.0, human.dimensions.ankle_height]


def reaching(
    human: Human,
    q: Float[Array, "n nv"],
    feet: Mapping[str, tuple[Array, Array | float]],
    stretched: Float[Array, " n"] | float = MAX_LEG_EXTENSION,
) -> Float[Array, "n nv"]:
    """Return postures whose legs reach for level feet, the nearer to them the better.

    Args:
        q: Postures; legs near the answer help.
        feet: Side → ankle joint, world (n, 3) or (3,) [m], and heading (n,) or one [rad].
        stretched: Part of their length that legs reach at most.
    """
    n = len(q)
    R = rotation_matrix(pelvis_angles_to_quaternion(q[:, :3]))
    pelvis = q[:, 3:6] @ OPENSIM_TO_WORLD.T
    hinges = q[:, 6:].copy()
    for side, (ankle, heading) in feet.items():
        leg = Leg(human, side)
        ankle = np.broadcast_to(ankle, (n, 3))
        heading = np.broadcast_to(np.asarray(heading, dtype=float), (n,))
        hip = pelvis + R @ leg.hip
        away = ankle - hip
        far = np.linalg.norm(away, axis=1)
        ankle = hip + away * np.minimum(1.0, stretched * leg.length / far)[:, None]
        # a bent leg to start from, so that the knee flexes in the right direction
        bend = 2.0 * np.arccos(np.clip(far / leg.length, 0.0, 1.0))
        knee, hip_flexion = leg.columns[3], leg.columns[0]
        hinges[:, knee] = np.clip(bend, *leg.limits[:, 3])
        forward = np.arctan2(away[:, 0], -away[:, 2]) + bend / 2
        hinges[:, hip_flexion] = np.clip(forward - q[:, 0], *leg.limits[:, 0])
        hinges[:, leg.columns[4]] = np.clip(bend - forward, *leg.limits[:, 4])
        level = about_vertical(heading)
        hinges = leg.reach(pelvis, R, hinges, ankle, level, iterations=60)
    return np.hstack([q[:, :6], hinges])


@dataclass(frozen=True)
class KeyPostures:
    """A first guess: postures at times, smooth in between, legs reaching for the feet."""

    times: tuple[float, ...]  #: When the postures are taken [s]
    postures: tuple[Float[Array, " nv"], ...] = field(repr=False)  #: Coordinates (n_times, nv)
    lift: float = 0.05  #: How high a foot is lifted between two of its stances [m]
    #: Part of their length that legs are short of stretched, but near the ends: a leg that is
    #: stretched while the hip moves away has a knee of any speed
    bent: float = 0.0

    def __call__(
        self, body: ContactBody, plan: ContactPlan, times: Float[Array, " n_times"]
    ) -> Float[Array, "n_times nv"]:
        """Return coordinates at times."""
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(self.times, np.array(self.postures), bc_type="clamped")
        q = spline(np.clip(times, self.times[0], self.times[-1]))
        feet = {s: level_foot(body.human, plan.stances, s, times, self.lift) for s in SIDES}
        stands = any(s.toe_off >= plan.duration for s in plan.stances)
        end = plan.duration if stands else np.inf
        inside = np.minimum(times, end - times) / STRETCHED_TIME
        return reaching(body.human, q, feet, MAX_LEG_EXTENSION - self.bent * quintic_rise(inside))


def level_foot(
    human: Human, stances: Sequence[Stance], side: str, times: Float[Array, " n_times"], lift: float
) -> tuple[Float[Array, "n_times 3"], Float[Array, " n_times"]]:
    """Return ankle [m] and heading [rad] of a foot that stays level from footprint to footprint."""
    stances = foot_stances(stances, side)
    knots = np.array([t for s in stances for t in (s.heel_strike, s.toe_off)])
    places = np.array([[*_ankle(human, s.footprint), s.footprint.heading] for s in stances])
    values = np.repeat(places, 2, axis=0)
    k = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    s = np.clip((times - knots[k]) / np.maximum(knots[k + 1] - knots[k], 1e-12), 0.0, 1.0)
    out = values[k] + quintic_rise(s)[:, None] * (values[k + 1] - values[k])
    out[:, 2] += np.where(k % 2 == 1, lift * 4 * s * (1 - s), 0.0)  # in the air
    return out[:, :3], out[:, 3]
