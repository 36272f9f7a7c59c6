"""From a fitted recording to everything that is known about it: one Record and its curves.

Filter and differentiate, find the gait events, share the plates out to the feet, compute the
joint moments, cut the cycles, measure the gait.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.analyze.gait import GaitMeasures, gait_measures
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.carriers import segment_forces
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.inverse import Moments, inverse_dynamics, residual_metrics
from plantigrade.dynamics.plates import FootForces, assign_plates, over_plates, sole_points
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.unmeasured import SIGNAL as ASSUMED
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers, Motion
from plantigrade.motion.cycles import Cycle, cut_cycles
from plantigrade.motion.events import detect_gait_events
from plantigrade.motion.filters import runs
from plantigrade.record import Record

CUTOFF = 6.0
"""Low-pass of motion and forces alike [Hz], usual for walking [Winter2009]_."""


@dataclass(frozen=True)
class FootPath:
    """Where the feet were."""

    heel: Float[Array, "n_frames 2 3"]  #: Back of the heel, right then left [m]
    #: Forefoot, right then left: midway between second metatarsal head and hallux [m]
    toe: Float[Array, "n_frames 2 3"]
    pelvis: Float[Array, "n_frames 3"]  #: Middle of the pelvis [m]


@dataclass(frozen=True)
class Trial:
    """A fitted recording, analysed."""

    fit: Fit  #: The fit; its Human has the mass that was found
    motion: Motion  #: The motion, filtered, with its gait events
    feet: FootPath  #: Paths of the feet
    cycles: tuple[Cycle, ...]  #: Gait cycles of both feet, by start
    measures: GaitMeasures  #: Spatio-temporal measures
    forces: FootForces | None  #: Ground reactions by foot, where they were measured
    moments: Moments | None  #: Inverse dynamics, where forces were measured
    notes: tuple[str, ...] = ()  #: What the user should know, one sentence each

    def record(self) -> Record:
        """Return motion, moments, measured forces and markers."""
        return self._record

    @cached_property
    def _record(self) -> Record:
        signals = {}
        if self.fit.residual is not None:
            signals["markers.residual"] = self.fit.residual
        if self.fit.assumed:
            signals[ASSUMED] = np.array(self.fit.assumed)
        markers, fitted = _markers(self.fit, self.motion)
        contact: dict[str, Any] = {}
        if self.forces is not None:
            contact = _contact(self.fit.human, self.motion, self.forces)
        return Record(
            self.fit.human,
            self.motion,
            qfrc_actuator=None if self.moments is None else self.moments.tau,
            **contact,
            signals=signals,
            recorded_markers=markers,
            fitted_markers=fitted,
            notes=tuple(dict.fromkeys(self.notes)),
        )

    @property
    def figures(self) -> dict[str, Any]:
        """Every figure of fit and gait: flat keys in snake_case, unit as suffix."""
        human, motion, age = self.fit.human, self.motion, self.fit.recording.subject.age
        figures = {
            **self.fit.metrics,
            "height_m": human.height,
            "mass_kg": human.mass,
            **({} if age is None else {"age_years": age}),
            "frames": motion.n_frames,
            "duration_s": motion.duration,
            "assumed_joints": list(self.fit.assumed),
            "heading_turned_deg": float(np.rad2deg(self.fit.heading)),
            **self.measures.metrics(),
        }
        if self.moments is not None and self.forces is not None:
            figures |= residual_metrics(self.moments, self.forces)
            figures |= _peak_moments(human, self.forces, self.moments)
        return figures


def analyse(fit: Fit, *, cutoff: float | None = CUTOFF, mass: float | None = None) -> Trial:
    """Analyse a fitted recording.

    Args:
        fit: The fit.
        cutoff: Low-pass of motion and forces [Hz]; None to leave them as they are.
        mass: Body mass given by the user [kg]; None: that of the file, or else the one that the
            measured forces carry.
    """
    human, notes = fit.human, list(fit.warnings)
    if mass is not None and abs(mass - human.mass) > 1e-9:
        human = human.with_mass(mass)
    given = mass is not None or fit.recording.subject.mass is not None
    cutoff = _possible_cutoff(fit.time, cutoff)
    smooth = differentiate(human, fit.time, fit.qpos, cutoff)
    feet = foot_path(human, fit.qpos)  # as fitted: the filter of the dynamics blurs contact
    events = detect_gait_events(fit.time, feet.heel, feet.toe, feet.pelvis)
    cycles = cut_cycles(events)
    forces = moments = found = None
    if fit.recording.plates:
        plates, soles = fit.recording.plates, sole_points(human, smooth.qpos)
        forces = assign_plates(plates, fit.time, soles, cutoff=cutoff)
        notes += forces.warnings
        if not given and cycles:
            found = mass_from_forces(fit.time, forces, cycles)
        elif not given:
            over = over_plates(plates, soles) | forces.valid
            found = mass_from_standing(fit.time, plates, over)
        if found is not None:
            human = human.with_mass(found)
            notes.append(f"the file gives no body mass; the force plates show {found:.1f} kg.")
        moments = inverse_dynamics(human, smooth.qpos, smooth.qvel, smooth.qacc, forces)
    if not given and found is None:
        notes.append(
            f"the body mass is unknown; {human.mass:.1f} kg is assumed for this height "
            "(set it with --mass)."
        )
    motion = Motion(fit.time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc, events)
    measures = gait_measures(fit.time, feet.heel, feet.toe, events)
    return Trial(
        replace(fit, human=human), motion, feet, cycles, measures, forces, moments, tuple(notes)
    )


def foot_path(human: Human, qpos: Float[Array, "n_frames nq"]) -> FootPath:
    """Return heel, toe and pelvis of a motion [m]."""
    table = attachments(human)
    marks = ("heel", "metatarsal_2_head", "hallux", "asis", "psis")
    names = [f"{mark}_{side}" for mark in marks for side in SIDES]
    points = PointSet(
        human, [table[n].body for n in names], np.array([table[n].position for n in names])
    )
    x = points.path(qpos)
    return FootPath(x[:, 0:2], (x[:, 2:4] + x[:, 4:6]) / 2, x[:, 6:].mean(axis=1))


def mass_from_standing(time, plates, known) -> float | None:
    """Return the body mass on the plates [kg]: the median of their total vertical force.

    ``known`` are the frames in which the plates carry the whole person.
    """
    total = np.zeros(len(time))
    for plate in plates:
        push = np.nan_to_num(plate.force[:, 2])
        total += np.interp(time, plate.time, push, left=0.0, right=0.0)
    steady = total[known & (total > 50)]
    return float(np.median(steady) / GRAVITY) if len(steady) > 10 else None


def mass_from_forces(time, forces: FootForces, cycles) -> float | None:
    """Return the body mass that the forces of a walk carry [kg]; None where they cannot tell.

    Over a stride the impulses of one stance of each foot make up body weight times the stride's
    duration, for the body neither rises nor sinks from stride to stride.
    """
    vertical = forces.force[..., 2]
    dt = float(np.median(np.diff(time)))
    weights: dict[str, list[float]] = {"l": [], "r": []}
    for c in cycles:
        if c.toe_off is None:
            continue
        k = forces.sides.index(c.side)
        stance = (time >= c.start - 0.03) & (time <= c.toe_off + 0.03)
        known = _leg_known(forces, c.side)[stance]
        if known.mean() > 0.97 and vertical[stance, k].max() > 100:
            weights[c.side].append(float(vertical[stance, k].sum() * dt / c.duration))
    if not weights["l"] and not weights["r"]:
        stride = np.median([c.duration for c in cycles])
        return _mass_from_stances(time, forces, vertical, dt, stride)
    sides = [float(np.mean(w)) for w in weights.values() if w]
    return float(2 * np.mean(sides) / GRAVITY)


def _mass_from_stances(time, forces, vertical, dt, stride) -> float | None:
    """Use single stances on a plate where no whole cycle was seen."""
    impulses = []
    for k, side in enumerate(forces.sides):
        on = (vertical[:, k] > 20) & _leg_known(forces, side)
        for run in runs(on):
            if 0 < run.start and run.stop < len(on) and (run.stop - run.start) * dt > 0.3:
                impulses.append(float(vertical[run, k].sum() * dt / stride))
    return float(2 * np.mean(impulses) / GRAVITY) if impulses else None


def _leg_known(forces: FootForces, side: str) -> np.ndarray:
    """Return the frames in which the force on one foot is known (also when it is in the air)."""
    return np.asarray(forces.valid_side)[:, forces.sides.index(side)]


def _possible_cutoff(time, cutoff: float | None) -> float | None:
    """Return the cut-off, or None where the frame rate is too low for it to do anything."""
    if cutoff is None or len(time) < 12:
        return None
    rate = (len(time) - 1) / (time[-1] - time[0])
    return cutoff if cutoff < 0.45 * rate else None


def _contact(human: Human, motion: Motion, forces: FootForces) -> dict[str, Any]:
    """Return the measured forces by the segments that carry them, as fields of a Record."""
    carried = segment_forces(human, motion.qpos, forces.force, forces.point, forces.torque)
    sites = tuple(
        ContactSite(body=f"{segment}_{side}", name=f"{segment}_{side}", side=side, measured=True)
        for segment, side in zip(carried.segment, carried.side, strict=True)
    )
    return {
        "sites": sites,
        "contact_force": carried.force,
        "contact_point": carried.point,
        "contact_torque": carried.torque,
        "contact_known": np.stack([_leg_known(forces, s.side) for s in sites], axis=1),
    }


def _markers(fit: Fit, motion: Motion) -> tuple[Markers | None, np.ndarray | None]:
    """Return the recorded markers that were used, and the same markers on the body."""
    if fit.markers is None:
        return None, None
    seen = fit.markers.positions
    if fit.kept is not None:
        seen = np.where(fit.kept[..., None], seen, np.nan)
    places = np.array([place.position for place in fit.places])
    points = PointSet(fit.human, [place.body for place in fit.places], places)
    return Markers(fit.markers.names, fit.markers.time, seen), points.path(motion.qpos)


def _peak_moments(human: Human, forces: FootForces, moments: Moments) -> dict[str, float]:
    """Return the largest sagittal moments of hip, knee and ankle [N m/kg]."""
    peaks = {}
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        for side in SIDES:
            moment = moments[f"{name}_{side}"][_leg_known(forces, side)] / human.mass
            if len(moment):
                peak = moment[np.abs(moment).argmax()]
                peaks[f"{name}_moment_peak_{side}_nm_kg"] = float(peak)
    return peaks
