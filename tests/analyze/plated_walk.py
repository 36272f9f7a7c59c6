"""The textbook walk on a person, with the ground reactions that its own dynamics ask for."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from unittest.mock import patch

import mujoco
import numpy as np

from plantigrade.analyze import trial
from plantigrade.dynamics import plate_checks
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.textbook_recording import TextbookWalk, textbook_walk
from plantigrade.models import Human
from plantigrade.motion import ForcePlate, Recording, Subject

MASS = 71.0
FAR = 1.0  # the textbook walk does not sway: its pressure runs between the feet [m]
SMOOTH = 5.0  # low-pass of the walk, whose planted feet stop dead [Hz]
LEAST = 0.06  # share of the load from which a foot carries: above the threshold of contact


@dataclass(frozen=True)
class PlatedWalk:
    """A walk whose ground reactions are known exactly.

    Attributes:
        walk: The walk, smooth.
        qpos: Its configurations.
        qvel: Velocities.
        qacc: Accelerations.
        tau: What inverse dynamics without the ground leaves, (n_frames, nv).
        plates: One per foot, right first; each says its side.
    """

    walk: TextbookWalk
    qpos: np.ndarray
    qvel: np.ndarray
    qacc: np.ndarray
    tau: np.ndarray
    plates: tuple[ForcePlate, ForcePlate]

    def fit(self, *, known_mass: bool = True, mass: float | None = None) -> Fit:
        """Return the walk as a fit, on a person of its mass or another."""

        human = self.walk.human if mass is None else self.walk.human.with_mass(mass)
        subject = Subject(mass=human.mass if known_mass else None)
        recording = Recording(Path("walk.c3d"), plates=self.plates, subject=subject)
        return Fit(human, self.walk.time, self.walk.qpos, recording, "coordinates")


def analyse(fit: Fit, **options) -> trial.Trial:
    """Analyse a fit whose centre of pressure need not lie under the foot."""
    with patch.object(plate_checks, "MAX_SOLE_DISTANCE", FAR):
        return trial.analyse(fit, **options)


@cache
def plated_walk(feet: str = "rigid") -> PlatedWalk:
    """Return the walk with forces ``mass * (acceleration of the centre of mass - gravity)``.

    The root of the inverse dynamics holds the whole ground reaction and its moment; it is taken to
    the point of the ground where it has no horizontal moment. In double support the load passes
    from foot to foot in a straight line over time.
    """
    human = Human.create(1.74, MASS, "male", "42", feet)
    walk = textbook_walk(human, cycles=3)
    walk = replace(walk, qpos=differentiate(human, walk.time, walk.qpos, SMOOTH).qpos)
    smooth = differentiate(human, walk.time, walk.qpos, None)
    model, data = plain(human), mujoco.MjData(plain(human))
    n = len(walk.time)
    tau, force, cop, free = np.zeros((n, model.nv)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    for f in range(n):
        data.qpos[:], data.qvel[:], data.qacc[:] = smooth.qpos[f], smooth.qvel[f], smooth.qacc[f]
        mujoco.mj_inverse(model, data)
        tau[f] = data.qfrc_inverse
        rotation = data.xmat[1].reshape(3, 3)
        force[f] = tau[f, :3]
        moment = rotation @ tau[f, 3:6] + np.cross(data.qpos[:3], force[f])  # about the origin
        cop[f, :2] = [-moment[1] / force[f, 2], moment[0] / force[f, 2]]
        free[f] = (moment - np.cross(cop[f], force[f]))[2]
    right = right_share(walk)
    plates = []
    for share, side in ((right, "r"), (1 - right, "l")):
        on = (share > 0)[:, None]
        plates.append(
            ForcePlate(
                side,
                walk.time,
                share[:, None] * force,
                np.where(on, cop, np.nan),
                share * free,
                side=side,
            )
        )
    return PlatedWalk(walk, smooth.qpos, smooth.qvel, smooth.qacc, tau, (plates[0], plates[1]))


def right_share(walk: TextbookWalk) -> np.ndarray:
    """Return the share of the load on the right foot by the walk's own events."""
    loads = {}
    for side in "rl":
        events = [(e.time, e.kind) for e in walk.events if e.side == side]
        # a stance that began before the recording or ends after it
        first = events[0] if events else (0.0, "heel_strike")
        standing = first[1] == "toe_off"
        load = np.full(len(walk.time), standing)
        for time, kind in events:
            load[walk.time >= time - 1e-9] = kind == "heel_strike"
        loads[side] = load
    share = np.where(loads["r"] & ~loads["l"], 1.0, 0.0)
    both = loads["r"] & loads["l"]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], both.astype(int), [0]])))
    for a, b in edges.reshape(-1, 2):
        to = share[b] if b < len(share) else 1.0 - share[a - 1]
        passed = np.linspace(LEAST, 1 - LEAST, b - a)
        share[a:b] = passed if to == 1.0 else 1 - passed
    return share


def plain(human: Human) -> mujoco.MjModel:
    """Return the person in plain MuJoCo, without contacts and limits."""
    model = mujoco.MjModel.from_xml_string(human.xml)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    return model


def standing_fit(human: Human, plates: tuple[ForcePlate, ...], n: int = 150) -> Fit:
    """Return a person who stands on plates."""
    time = np.arange(n) / 100
    qpos = np.tile(human.standing(), (n, 1))
    recording = Recording(Path("static.c3d"), plates=plates)
    return Fit(human, time, qpos, recording, "coordinates")


def without_plates(fit: Fit) -> Fit:
    """Return the fit of a recording without forces."""
    return replace(fit, recording=replace(fit.recording, plates=()))
