"""Path of the pelvis from footprint to footprint, and the double supports that it passes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan, Stance
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.textbook_gait import FREE_SPEED
from plantigrade.spatial.conventions import (
    pelvis_angles_to_quaternion,
    rotation_matrix,
    within_half_turn,
)
from plantigrade.trajopt.guess.mean_gait import MeanGait
from plantigrade.trajopt.guess.postures import foot_stances, level_rotations
from plantigrade.trajopt.tasks.gait_parameters import GaitParameters

SWAY_AMPLITUDE = 0.022  # [leg lengths] sway towards the stance foot at free speed; more when slow
HOLD_SHARE = 0.4  # [1] share of a rest with a motionless body


@dataclass(frozen=True)
class DoubleSupport:
    """Both feet on the ground [s]."""

    start: float
    stop: float
    place: Float[Array, " 4"]  #: Between the feet: x, y, ground [m], heading [rad]
    rest: str = ""  #: ``"before"`` or ``"after"`` the walk, or empty in between

    @property
    def held(self) -> float:
        """From or until when the body is still, in a rest [s]."""
        hold = HOLD_SHARE * (self.stop - self.start)
        return self.start + hold if self.rest == "before" else self.stop - hold


def double_supports(plan: ContactPlan, stances: Sequence[Stance]) -> list[DoubleSupport]:
    """Return the double supports of a plan, in order; no two at the same time."""
    out = []
    for k, s in enumerate(stances):
        partners = [
            p
            for p in stances[:k]
            if p.footprint.side != s.footprint.side and p.toe_off >= s.heel_strike >= p.heel_strike
        ]
        if not partners:
            continue
        p = partners[-1]
        start, stop, rest = s.heel_strike, min(p.toe_off, s.toe_off), ""
        if not plan.periodic:
            if max(s.foot_flat, p.foot_flat) <= 0:
                start, rest = 0.0, "before"
            if min(s.heel_off, p.heel_off) >= plan.duration:
                stop, rest = plan.duration, "after"
        out.append(DoubleSupport(start, stop, midway(s, p), rest))
    if not out:
        raise ParameterError("a walk needs a moment with both feet on the ground")
    return out


def phases(
    stances: Sequence[Stance], supports: Sequence[DoubleSupport]
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return times of heel strikes and the phase of the right foot's stride at each."""
    begin = supports[0].stop if supports[0].rest == "before" else -np.inf
    strikes = [s for s in stances if s.heel_strike >= begin] or list(stances[-1:])
    first = 0.0 if strikes[0].footprint.side == "r" else 0.5
    return np.array([s.heel_strike for s in strikes]), first + 0.5 * np.arange(len(strikes))


def walking_share(
    supports: Sequence[DoubleSupport],
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return times and the share of walking then."""
    knots = [(s.held, 0.0) if s.rest else ((s.start + s.stop) / 2, 1.0) for s in supports]
    return np.array([t for t, _ in knots]), np.array([w for _, w in knots])


class PelvisPath:
    """Path of the pelvis."""

    def __init__(
        self,
        human: Human,
        supports: Sequence[DoubleSupport],
        stances: Sequence[Stance],
        parameters: GaitParameters,
    ):
        from scipy.interpolate import PchipInterpolator

        p = parameters
        self._ahead, self._height = -human.skeleton.origins["foot_r"][0], human.standing()[2]
        times, places = [], []
        for s in supports:
            rest = {"before": [s.start, s.held], "after": [s.held, s.stop]}.get(s.rest, [s.start])
            times += rest
            places += [s.place] * len(rest)
        places = np.array(places)
        places[:, 3] = np.unwrap(places[:, 3])
        step = np.zeros_like(places)
        step[:, :2] = ahead(step[:, :2], places[:, 3], p.step_length)
        if not supports[0].rest:
            times = [times[0] - p.step_time, *times]
            places = np.vstack([places[0] - step[0], places])
        if not supports[-1].rest:
            times = [*times, times[-1] + p.step_time]
            places = np.vstack([places, places[-1] + step[-1]])
        self._span = times[0], times[-1]
        self._place = PchipInterpolator(times, places)
        size = float(
            SWAY_AMPLITUDE * p.leg_length * np.clip(FREE_SPEED / p.relative_speed, 0.6, 2.0)
        )
        sways = [(t, 0.0) for t in times]
        for side, sway in (("r", size), ("l", -size)):
            own = foot_stances(stances, side)
            for a, b in zip(own[:-1], own[1:], strict=True):
                sways.append(((a.toe_off + b.heel_strike) / 2, sway))
        self._sway = PchipInterpolator(*np.array(sorted(sways)).T)

    def pelvis(
        self, gait: MeanGait, times: Float[Array, " n"]
    ) -> tuple[Float[Array, "n 3"], Float[Array, "n 3 3"]]:
        """Return position, at the height of standing, and rotation of the pelvis."""
        t = np.clip(times, *self._span)
        place, sway = self._place(t), self._sway(t)
        heading = place[:, 3]
        position = np.empty((len(t), 3))
        position[:, :2] = ahead(place[:, :2], heading, self._ahead)
        position[:, 0] -= np.sin(heading) * sway
        position[:, 1] += np.cos(heading) * sway
        position[:, 2] = place[:, 2] + self._height
        own = rotation_matrix(pelvis_angles_to_quaternion(gait.pelvis_angles(times)))
        return position, level_rotations(heading) @ own


def midway(a: Stance, b: Stance) -> Float[Array, " 4"]:
    """Return the place between two footprints: x, y, ground [m], heading [rad]."""
    middle = (np.array(a.footprint.position) + np.array(b.footprint.position)) / 2
    turn = within_half_turn(b.footprint.heading - a.footprint.heading)
    return np.array([*middle, a.footprint.heading + turn / 2])


def ahead(
    place: Float[Array, "n 2"], heading: Float[Array, " n"], distance: float
) -> Float[Array, "n 2"]:
    """Return places some distance ahead [m]."""
    return place + distance * np.stack([np.cos(heading), np.sin(heading)], axis=1)
