"""Analysis of a fitted recording: one Record and its curves.

The steps are filtering and differentiation, detection of gait events, assignment of plates to feet,
estimation of unmeasured forces, joint moments, gait cycles, and gait measures.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from plantigrade.analyze.body_mass import MeasuredMass
from plantigrade.analyze.estimated_forces import (
    estimate,
    estimate_figures,
    estimate_signals,
    residual_wrench,
    support_forces,
)
from plantigrade.analyze.feet import FootPath, event_points, foot_path
from plantigrade.analyze.force_tilt import force_tilt, tilt_note
from plantigrade.analyze.gait import GaitMeasures, gait_measures
from plantigrade.analyze.plate_forces import (
    PlateResults,
    add_mass_note,
    evaluate_plates,
    off_plate_notes,
    on_feet,
    required_lift,
)
from plantigrade.analyze.standing_soles import sole_notes, standing_soles
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Seat
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.ground_forces import GroundForces
from plantigrade.dynamics.inverse import Moments, com_metrics, inverse_dynamics, residual_metrics
from plantigrade.dynamics.loading import leaves_the_ground
from plantigrade.dynamics.plates import FootForces, sole_points
from plantigrade.dynamics.segment_loads import segment_forces
from plantigrade.kinematics.fitted_soles import height_figures
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.sole_paths import SolePaths, sole_paths
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.unmeasured_joints import SIGNAL as ASSUMED
from plantigrade.models import Human
from plantigrade.motion import ForcePlate, GaitEvent, Markers, Motion
from plantigrade.motion.cycles import Cycle, cut_cycles
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.events import detect_gait_events
from plantigrade.motion.recording import rate_of
from plantigrade.notes import Info
from plantigrade.record import Record

CUTOFF = 6.0
"""Low-pass of motion and forces alike [Hz], usual for walking [Winter2009]_."""
RUNNING_CUTOFF = 15.0
"""Low-pass of motion and forces in running [Hz] [Hamner2013]_ and in jumps [Kristianslund2012]_."""


@dataclass(frozen=True)
class Trial:
    """An analysed recording."""

    fit: Fit  #: The fit, with the body mass that was determined
    motion: Motion  #: The motion, filtered, with its gait events
    feet: FootPath  #: Paths of the feet
    cycles: tuple[Cycle, ...]  #: Gait cycles of both feet, by start
    measures: GaitMeasures  #: Spatio-temporal measures
    forces: FootForces | None  #: Measured ground reactions by foot
    #: Inverse dynamics with measured and estimated forces on the feet; the force of a seat remains
    #: at the root
    moments: Moments | None
    #: Height of the lowest point of each sole above the ground (right, left) [m]; NaN in swing
    soles: Float[Array, "n_frames 2"] | None = None
    notes: tuple[str, ...] = ()  #: Notes for the user
    cutoff: float | None = None  #: Low-pass of motion and forces [Hz]
    weighed: MeasuredMass | None = None  #: Body mass measured by the plates
    events_from_plates: int = 0  #: Number of gait events timed by plates
    plate_clock_offset: float | None = None  #: Delay of the plates, if it can be estimated [s]
    #: Ground reactions of every foot in every frame, estimated if not measured
    ground: GroundForces | None = None
    #: Withheld measured ground reactions, and joint moments by them
    withheld: tuple[FootForces, Moments] | None = None

    def record(self) -> Record:
        """Return motion, moments, forces (measured, or estimated with bands) and markers."""
        return self._record

    @cached_property
    def measured(self) -> Record | None:
        """The record with measured forces only; None without plates."""
        if self.withheld is None:
            return None if self.forces is None else self._record
        forces, moments = self.withheld
        human, motion = self.fit.human, self.motion
        contact = _contact(self.fit, motion, forces)
        return Record(human, motion, qfrc_actuator=moments.tau, **contact)

    @cached_property
    def _record(self) -> Record:
        signals = {}
        if self.fit.residual is not None:
            signals["markers.residual"] = self.fit.residual
        if self.fit.assumed:
            signals[ASSUMED] = np.array(self.fit.assumed)
        markers, fitted = _markers(self.fit, self.motion)
        contact: dict[str, Any] = {}
        torque = None if self.moments is None else self.moments.tau
        if self.ground is not None and torque is not None:
            torque = torque - support_forces(self.fit.human, self.motion, self.ground)
            signals |= estimate_signals(self.ground)
            contact = _contact(self.fit, self.motion, self.ground.forces, self.ground)
        elif self.forces is not None:
            contact = _contact(self.fit, self.motion, self.forces)
        return Record(
            self.fit.human,
            self.motion,
            qfrc_actuator=torque,
            **{"ground": self.fit.ground, **contact},
            signals=signals,
            recorded_markers=markers,
            fitted_markers=fitted,
            notes=tuple(dict.fromkeys(self.notes)),
        )

    @property
    def figures(self) -> dict[str, Any]:
        """Every figure of fit and gait: flat keys in snake_case, unit as suffix."""
        human, motion, subject = self.fit.human, self.motion, self.fit.recording.subject
        late = self.plate_clock_offset
        figures = {
            **self.fit.metrics,
            "height_m": human.height,
            "mass_kg": human.mass,
            **({} if self.weighed is None else {"mass_on_plates_kg": self.weighed.mass}),
            **({} if self.cutoff is None else {"cutoff_hz": self.cutoff}),
            "events_from_plates_count": self.events_from_plates,
            **({} if late is None else {"plate_clock_offset_ms": 1e3 * late}),
            **subject.figures,
            "frames": motion.n_frames,
            "duration_s": motion.duration,
            "assumed_joints": list(self.fit.assumed),
            "heading_turned_deg": float(np.rad2deg(self.fit.heading)),
            **self.measures.metrics(),
            **({} if self.soles is None else height_figures(self.soles)),
        }
        if self.moments is not None and self.forces is not None:
            figures |= residual_metrics(self.moments, self.forces)
            figures |= com_metrics(self.moments, self.forces, motion.qpos)
            figures |= _peak_moments(human, self.forces, self.moments)
        if self.ground is not None and self.moments is not None:
            force, moment = residual_wrench(human, motion, self.ground, self.moments)
            figures |= {
                **estimate_figures(human, self.ground),
                "estimate_residual_force_rms_bw": force,
                "estimate_residual_moment_rms_bw_m": moment,
            }
        return figures


def _given_plates(fit: Fit, withheld: bool, notes: list[str]) -> tuple[ForcePlate, ...]:
    """Return the plates of a recording; none where they are withheld, with a note."""
    if withheld and fit.recording.plates:
        notes.append(Info("force plates withheld: forces and moments are estimated from motion."))
        return ()
    return fit.recording.plates


def _cutoff(
    fit: Fit, cutoff: float | Literal["usual"] | None, events: Sequence[GaitEvent], notes: list[str]
) -> float | None:
    """Return the low-pass of an analysis [Hz]; None for no filter."""
    if cutoff == "usual":
        soles = None if events else sole_paths(fit.human, fit.qpos, fit.ground)
        cutoff = usual_cutoff(fit.time, soles, events, notes)
    return _possible_cutoff(fit.time, cutoff)


def analyse(
    fit: Fit,
    *,
    cutoff: float | Literal["usual"] | None = "usual",
    mass: float | None = None,
    without_plates: bool = False,
) -> Trial:
    """Analyse a fitted recording.

    Args:
        cutoff: Low-pass of motion and forces [Hz]; by default :data:`CUTOFF`, in running and jumps
            :data:`RUNNING_CUTOFF`; None for no filter.
        mass: Body mass [kg]; by default that of the file, or else by the plates.
        without_plates: Withhold the plates from the estimation of forces, for a comparison.
    """
    notes, human = list(fit.warnings), fit.human
    if mass is not None and abs(mass - human.mass) > 1e-9:
        human = human.with_mass(mass)
    plates = _given_plates(fit, without_plates, notes)
    subject = fit.recording.subject
    given = mass is not None or subject.mass is not None
    feet = foot_path(human, fit.qpos)  # unfiltered, because the filter smooths contacts
    heel, ball = event_points(fit)
    events = detect_gait_events(fit.time, heel, ball, feet.pelvis)
    cutoff = _cutoff(fit, cutoff, events, notes)
    smooth = differentiate(human, fit.time, fit.qpos, cutoff)
    kinematics = (human, smooth.qpos, smooth.qvel, smooth.qacc)
    found = PlateResults(events)
    if plates:
        known: Any = {"cutoff": cutoff, "mass": human.mass if given else None, "notes": notes}
        found = evaluate_plates(plates, fit.time, kinematics, feet, events, **known)
    forces, events, weighed = found.forces, found.events, found.weighed
    add_mass_note(human, weighed, given, forces is not None, subject.age, notes)
    if weighed is not None and not given:
        human = human.with_mass(weighed.mass)
    motion = Motion(fit.time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc, events)
    heights = standing_soles(fit, events, forces)
    notes += sole_notes(heights)
    what = human, motion, forces, heights, fit.ground, fit.force_band_factor
    ground, moments, estimate_notes = estimate(*what)
    notes += [*off_plate_notes(forces, ground is not None), *estimate_notes]
    if ground is None and forces is not None:
        moments = inverse_dynamics(human, *kinematics[1:], forces)
    cycles = cut_cycles(events)
    notes += _tilt_notes(fit.time, forces, moments, cycles)
    return Trial(
        fit=replace(fit, human=human),
        motion=motion,
        feet=feet,
        cycles=cycles,
        measures=gait_measures(fit.time, feet.heel, feet.toe, events),
        forces=forces,
        moments=moments,
        soles=heights,
        notes=tuple(notes),
        cutoff=cutoff,
        weighed=weighed,
        events_from_plates=found.n_events,
        plate_clock_offset=found.clock_offset,
        ground=ground,
        withheld=_withheld(fit, motion, human, cutoff, given) if without_plates else None,
    )


def _tilt_notes(
    time: Float[Array, " n_frames"],
    forces: FootForces | None,
    moments: Moments | None,
    cycles: tuple[Cycle, ...],
) -> list[str]:
    """Return a warning if forces are measured and lean over whole strides."""
    if forces is None or moments is None:
        return []
    note = tilt_note(force_tilt(time, forces, moments, cycles))
    return [note] if note else []


def usual_cutoff(
    time: Float[Array, " n_frames"],
    soles: SolePaths | None,
    events: Sequence[GaitEvent],
    notes: list[str],
) -> float:
    """Return the usual low-pass of a motion [Hz]; add a note if it has a flight.

    Args:
        time: Time of each frame [s].
        soles: Paths of the soles; None where a jump need not be looked for.
        notes: Notes, to which one may be added.
    """
    flight = "runs" if is_running(events) else ""
    if not events and soles is not None and leaves_the_ground(time, soles):
        flight = "jumps"
    if not flight:
        return CUTOFF
    notes.append(
        Info(
            f"the person {flight}: motion and forces are low-pass filtered at {RUNNING_CUTOFF:g} "
            f"Hz, not at the {CUTOFF:g} Hz used for walking (set it with --cutoff)."
        )
    )
    return RUNNING_CUTOFF


def _withheld(
    fit: Fit, motion: Motion, human: Human, cutoff: float | None, given: bool
) -> tuple[FootForces, Moments] | None:
    """Return measured forces and joint moments by them; None without plates."""
    if not fit.recording.plates or motion.qacc is None:
        return None
    kinematics = (human, motion.qpos, motion.qvel, motion.qacc)
    soles, body = sole_points(human, motion.qpos), centroid(*kinematics)
    lift, mass = required_lift(human, body), human.mass if given else None
    forces, _, _ = on_feet(fit.recording.plates, motion.time, soles, body, cutoff, mass, lift)
    return forces, inverse_dynamics(*kinematics, forces)


def _possible_cutoff(time, cutoff: float | None) -> float | None:
    """Return the cut-off, or None if the frame rate is too low for it."""
    if cutoff is None or len(time) < 12:
        return None
    rate = rate_of(time)
    return cutoff if cutoff < 0.45 * rate else None


def _leg_known(forces: FootForces, side: str) -> np.ndarray:
    """Return the frames in which the force on one foot is known, flight included."""
    return np.asarray(forces.valid_side)[:, forces.sides.index(side)]


def _contact(
    fit: Fit, motion: Motion, forces: FootForces, ground: GroundForces | None = None
) -> dict[str, Any]:
    """Return forces on segments and supports as fields of a Record."""
    carried = segment_forces(fit.human, motion.qpos, forces.force, forces.point, forces.torque)
    sites = tuple(
        ContactSite(body=f"{segment}_{side}", name=f"{segment}_{side}", side=side, measured=True)
        for segment, side in zip(carried.segment, carried.side, strict=True)
    )
    known = np.stack([_leg_known(forces, s.side) for s in sites], axis=1)
    found: dict[str, Any] = {
        "ground": fit.ground,
        "contact_force": carried.force,
        "contact_point": carried.point,
        "contact_torque": carried.torque,
        "contact_known": known,
    }
    if ground is not None and ground.supports:
        sites += tuple(
            ContactSite(body=s.body, name=s.name, side="", part="chair", measured=True)
            for s in ground.supports
        )
        more = (ground.support_force, ground.support_point, ground.support_torque)
        more = (*more, np.ones(ground.support_force.shape[:2], dtype=bool))
        found |= {
            f"contact_{name}": np.concatenate([found[f"contact_{name}"], theirs], axis=1)
            for name, theirs in zip(("force", "point", "torque", "known"), more, strict=True)
        }
        seats = []
        for support, points in zip(
            ground.supports, ground.support_point.swapaxes(0, 1), strict=True
        ):
            if np.isfinite(points).all(axis=1).any():
                x, y, z = (float(each) for each in np.nanmedian(points, axis=0))
                seats.append(Seat(support.name, (x, y, z)))
        found["ground"] = replace(fit.ground, seats=tuple(seats))
    return {"sites": sites, **found}


def _markers(fit: Fit, motion: Motion) -> tuple[Markers | None, np.ndarray | None]:
    """Return the recorded markers used by the fit, and their fitted positions."""
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
