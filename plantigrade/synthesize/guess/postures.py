r"""Postures a task starts from, ends in or passes, and the way between them as a first guess.

A posture here is given by where the pelvis is, how it leans and what trunk and arms do; the legs
then reach for the feet, which stand flat on their footprints.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    pelvis_angles_to_quaternion,
    rotation_matrix,
)
from plantigrade.synthesize.guess.legs import Leg
from plantigrade.synthesize.problem.contact_body import ContactBody

STRETCHED = 0.999  # of thigh and shank: as far as a leg of a guess is stretched


def standing_feet(human: Human) -> dict[str, Footprint]:
    """Return where the feet are in the person's quiet standing at the origin."""
    out = {}
    for side in ("r", "l"):
        x, y, _ = human.skeleton.origins[f"foot_{side}"]
        out[side] = Footprint(side, (float(x), float(y), 0.0))
    return out


def standing_stances(
    feet: Mapping[str, Footprint], duration: float, start: float | None = None
) -> tuple[Stance, ...]:
    """Return feet that stand flat throughout a motion, or from ``start`` [s] on."""
    begin, end = -1.0 if start is None else start, duration + 1.0
    return tuple(Stance(foot, begin, begin, end, end, end) for foot in feet.values())


def standing_posture(human: Human) -> Float[Array, " nv"]:
    """Return the coordinates of quiet standing at the origin."""
    return human.to_coordinates(human.standing()[None])[1][0]


def posture(
    human: Human,
    feet: Mapping[str, Footprint],
    *,
    hip: tuple[float, float],
    tilt: float = 0.0,
    shift: float = 0.0,
    joints: Mapping[str, float] | None = None,
) -> Float[Array, " nv"]:
    """Return the coordinates of a posture on both feet, or as near to it as the legs reach.

    Args:
        human: The person.
        feet: Where the feet stand.
        hip: Middle of the hip joints: forward and up, world [m].
        tilt: How far the pelvis is tilted, backwards positive as in OpenSim [rad].
        shift: Middle of the hip joints to the left [m].
        joints: Coordinates of trunk and arms by name, with side or without [rad]; those of
            standing if not given.

    Raises:
        ParameterError: If there is no such coordinate.
    """
    q = standing_posture(human)
    names = human.coordinates
    for name, value in (joints or {}).items():
        columns = [i for i, n in enumerate(names) if n in (name, f"{name}_r", f"{name}_l")]
        if not columns:
            raise ParameterError(f"no coordinate {name!r}; there are {', '.join(names)}")
        q[[6 + i for i in columns]] = value
    q[:3] = tilt, 0.0, 0.0
    R = rotation_matrix(pelvis_angles_to_quaternion(q[None, :3]))[0]
    place = np.array([hip[0], shift, hip[1]]) - R @ _between_hips(human)
    q[3:6] = place @ OPENSIM_TO_WORLD
    return reaching(human, q[None], {s: (_ankle(human, f), f.heading) for s, f in feet.items()})[0]


def _between_hips(human: Human) -> Float[Array, " 3"]:
    """Return the middle between the hip joints in the pelvis' axes [m]."""
    return Leg(human, "r").hip * [1.0, 0.0, 1.0]


def _ankle(human: Human, foot: Footprint) -> Float[Array, " 3"]:
    return np.array(foot.position) + [0.0, 0.0, human.dimensions.ankle_height]


def reaching(
    human: Human,
    q: Float[Array, "n nv"],
    feet: Mapping[str, tuple[Array, Array | float]],
) -> Float[Array, "n nv"]:
    """Return postures whose legs reach for level feet, the nearer to them the better.

    Args:
        human: The person.
        q: Postures; legs near the answer help.
        feet: Side → ankle joint, world (n, 3) or (3,) [m], and heading (n,) or one [rad].
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
        ankle = hip + away * np.minimum(1.0, STRETCHED * leg.length / far)[:, None]
        c, s, o, i = np.cos(heading), np.sin(heading), np.zeros(n), np.ones(n)
        level = np.stack([np.stack(r, 1) for r in ([c, -s, o], [s, c, o], [o, o, i])], 1)
        # a bent leg to start from, so that the knee does not turn the wrong way
        bend = 2.0 * np.arccos(np.clip(far / leg.length, 0.0, 1.0))
        knee, hip_flexion = leg.columns[3], leg.columns[0]
        hinges[:, knee] = np.clip(bend, *leg.limits[:, 3])
        forward = np.arctan2(away[:, 0], -away[:, 2]) + bend / 2
        hinges[:, hip_flexion] = np.clip(forward - q[:, 0], *leg.limits[:, 0])
        hinges[:, leg.columns[4]] = np.clip(bend - forward, *leg.limits[:, 4])
        hinges = leg.reach(pelvis, R, hinges, ankle, level, iterations=60)
    return np.hstack([q[:, :6], hinges])


@dataclass(frozen=True)
class KeyPostures:
    """A first guess: postures at times, smooth in between, legs reaching for the feet.

    Attributes:
        times: When the postures are taken [s].
        postures: Coordinates (n_times, nv).
        lift: How high a foot is lifted between two of its stances [m].
        exact: Whether the postures are kept as they are where the body stands on flat feet; the
            legs are solved again elsewhere.
    """

    times: tuple[float, ...]
    postures: tuple[Float[Array, " nv"], ...] = field(repr=False)
    lift: float = 0.05

    def __call__(
        self, body: ContactBody, plan: ContactPlan, times: Float[Array, " n_times"]
    ) -> Float[Array, "n_times nv"]:
        """Return coordinates at times."""
        from scipy.interpolate import CubicSpline

        q = CubicSpline(self.times, np.array(self.postures), bc_type="clamped")(
            np.clip(times, self.times[0], self.times[-1])
        )
        feet = {s: level_foot(body.human, plan, s, times, self.lift) for s in ("r", "l")}
        return reaching(body.human, q, feet)


def level_foot(
    human: Human, plan: ContactPlan, side: str, times: Float[Array, " n_times"], lift: float
) -> tuple[Float[Array, "n_times 3"], Float[Array, " n_times"]]:
    """Return ankle [m] and heading [rad] of a foot that stays level from footprint to footprint.

    Raises:
        ParameterError: If the foot never stands.
    """
    stances: Sequence[Stance] = [s for s in plan.stances if s.footprint.side == side]
    if not stances:
        raise ParameterError(f"the {'right' if side == 'r' else 'left'} foot has no stance")
    knots, values = [], []
    for s in stances:
        place = [*_ankle(human, s.footprint), s.footprint.heading]
        knots += [s.heel_strike, s.toe_off]
        values += [place, place]
    out = np.empty((len(times), 4))
    values = np.array(values)
    for i, t in enumerate(times):
        k = int(np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2))
        s = float(np.clip((t - knots[k]) / max(knots[k + 1] - knots[k], 1e-12), 0.0, 1.0))
        ease = s**3 * (10 - 15 * s + 6 * s * s)
        out[i] = values[k] + ease * (values[k + 1] - values[k])
        if k % 2 == 1:  # in the air
            out[i, 2] += lift * 4 * s * (1 - s)
    return out[:, :3], out[:, 3]
