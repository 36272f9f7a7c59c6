"""Analysis of a recording on a person's own OpenSim model: events, plates, moments, one Record."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.feet import FootPath
from plantigrade.analyze.gait import gait_measures
from plantigrade.analyze.plate_forces import evaluate_plates
from plantigrade.analyze.trial import usual_cutoff
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.osim_moments import OsimMotion, osim_moments, osim_motion
from plantigrade.dynamics.plates import FootForces
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.osim_shapes import foot_bodies
from plantigrade.kinematics.osim_inverse import OsimFit
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import PointSet
from plantigrade.motion import ForcePlate, Motion
from plantigrade.motion.events import detect_gait_events
from plantigrade.notes import Info
from plantigrade.record import Record


@dataclass(frozen=True)
class OsimTrial:
    """A recording on a person's own model, analysed."""

    record: Record
    figures: dict[str, Any]  #: Flat keys in snake_case, unit as suffix


def analyse_osim(
    fit: OsimFit, plates: tuple[ForcePlate, ...], cutoff: float | None = None
) -> OsimTrial:
    """Return motion, events, forces on the feet and moments of a fit.

    Args:
        cutoff: Low-pass of motion and forces [Hz]; by default 6, in running and jumps 15.
    """
    human, notes = fit.human, list(fit.notes)
    raw = human.poses(fit.u)
    feet, events = _feet(human, raw), ()
    if feet is not None:
        events = detect_gait_events(fit.time, feet.heel, feet.toe, feet.pelvis)
    if cutoff is None:
        soles = None if feet is None or events else sole_paths(human, raw)
        cutoff = usual_cutoff(fit.time, soles, events, notes)
    rate = (len(fit.time) - 1) / max(float(np.ptp(fit.time)), 1e-9)
    possible = len(fit.time) >= 12 and cutoff < 0.45 * rate
    motion = osim_motion(human, fit.time, fit.u, cutoff if possible else None)
    forces, offset = None, None
    if plates and feet is None:
        notes.append(
            "the ground reactions were left out: the model has no body calcn_r, calcn_l, foot_r or "
            "foot_l that they could act on."
        )
    elif plates and feet is not None:
        kinematics = (human, motion.qpos, motion.qvel, motion.qacc)
        found = evaluate_plates(
            plates,
            motion.time,
            kinematics,
            feet,
            events,
            cutoff=cutoff if possible else None,
            mass=human.mass,
            notes=notes,
        )
        forces, events, offset = found.forces, found.events, found.clock_offset
    notes.append(Info(_left_out(human)))
    record = Record(
        human,
        Motion(motion.time, motion.qpos, motion.qvel, human.joint_names, motion.qacc, events),
        qfrc_actuator=None if forces is None else osim_moments(human, motion, forces),
        **_contact(human, forces),
        signals={} if fit.residual is None else {"markers.residual": fit.residual},
        recorded_markers=fit.markers,
        fitted_markers=_fitted(fit, motion),
        notes=tuple(notes),
    )
    figures = {
        **({} if fit.residual is None else _errors(fit.residual)),
        "height_m": human.height,
        "mass_kg": human.mass,
        "cutoff_hz": cutoff if possible else None,
        "frames": len(motion.time),
        "duration_s": float(np.ptp(motion.time)),
        **({} if offset is None else {"plate_clock_offset_ms": 1e3 * offset}),
    }
    if feet is not None:
        figures |= gait_measures(motion.time, feet.heel, feet.toe, events).metrics()
    return OsimTrial(record, figures)


def _feet(human: OsimHuman, qpos: Float[Array, "n nq"]) -> FootPath | None:
    """Return the paths of feet and pelvis; None for a model without feet on both sides."""
    if set(foot_bodies(human.links)) != set(SIDES):
        return None
    heel, toe = sole_paths(human, qpos).ends
    return FootPath(heel, toe, qpos[:, :3])


def _contact(human: OsimHuman, forces: FootForces | None) -> dict[str, Any]:
    if forces is None:
        return {}
    feet = foot_bodies(human.links)
    sites = tuple(
        ContactSite(body=feet[side], name=feet[side], side=side, measured=True) for side in SIDES
    )
    return {
        "sites": sites,
        "contact_force": forces.force,
        "contact_point": forces.point,
        "contact_torque": forces.torque,
        "contact_known": np.asarray(forces.valid_side),
    }


def _fitted(fit: OsimFit, motion: OsimMotion) -> Float[Array, "n m 3"] | None:
    if fit.markers is None:
        return None
    spelled = {name.lower(): place for name, place in fit.human.places.items()}
    places = [spelled[name.lower()] for name in fit.markers.names]
    return PointSet.of(fit.human, places).path(motion.qpos)


def _errors(residual: Float[Array, "n m"]) -> dict[str, float]:
    """Return the marker errors, as a fit of a scaled human has them."""
    seen = np.isfinite(residual).any(axis=1)
    per_frame = np.sqrt(np.nanmean(residual[seen] ** 2, axis=1))
    per_marker = np.sqrt(np.nanmean(residual[seen] ** 2, axis=0))
    return {
        "marker_rms_mean_mm": 1e3 * float(per_frame.mean()),
        "marker_rms_worst_frame_mm": 1e3 * float(per_frame.max()),
        "marker_rms_worst_marker_mm": 1e3 * float(np.nanmax(per_marker)),
    }


def _left_out(human: OsimHuman) -> str:
    parts = [f"{count} {kind}" for kind, count in human.osim.left_out.items()]
    tied = (
        f"; {', '.join(human.osim.coupled)} follow other coordinates" if human.osim.coupled else ""
    )
    return f"left out of the model: {', '.join(parts) or 'nothing'}{tied}."
