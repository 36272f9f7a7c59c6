"""Runs of every kind made from the walk, with figures that are known."""

from dataclasses import replace

import numpy as np

from plantigrade.contact.site import foot_sites
from plantigrade.record import Record, Run
from tests.pages.walker import STRIDE

CHECKED = ("root_force", "slip", "knee_and_hip", "pressure")


def fitted(record: Record, **figures) -> Run:
    """A run of ``fit``: markers, measured forces, no reference."""
    known = {"walking_speed_m_s": 1.25, "cadence_steps_min": 109.0, "marker_rms_mean_mm": 10.2}
    known |= {"stance_r_pct": 62.0, "stance_l_pct": 62.1, "stride_length_r_m": 1.375}
    return Run(
        replace(record, references={}),
        "fit",
        title="A person walking",
        sentence="A made-up walk was written as markers and fitted back.",
        figures=known | figures,
    )


def estimated(record: Record, *, beside: str = "nothing", **figures) -> Run:
    """A run of ``fit`` whose forces were estimated, all of them or those of the left foot.

    Measured is ``beside`` it: nothing, the right foot by its plate, or both by withheld plates.
    """
    (n, nv), weight = record.motion.qvel.shape, record.weight
    is_measured = np.zeros((n, 2), bool)
    is_measured[:, 0] = beside == "plate"
    unknown = (~is_measured).astype(float)
    signals = {
        "forces.measured": is_measured,
        "forces.band": np.repeat(0.05 * weight * unknown[..., None], 3, axis=2),
        "forces.point_band": np.repeat(0.02 * unknown[..., None], 2, axis=2),
        "forces.torque_band": 3.0 * unknown,
        "forces.moment_band": np.full((n, nv), 20.0),
    }
    if beside == "withheld":
        names = ("knee_angle_r", "ankle_angle_l")
        moment = np.stack([record.torque(h) for h in names], axis=1) / record.human.mass
        signals |= {
            "measured.force": np.stack([0.9 * record.foot(s).force for s in "rl"], axis=1),
            "measured.moment": 1.1 * moment,
            "measured.moment_names": np.array(names),
        }
    return fitted(replace(record, signals=signals), **figures)


def from_tasks(record: Record, *, forces: bool = False, measured: bool = False) -> Run:
    """A run of ``reproduce``: five tasks, the recorded motion, forces beside it."""
    bare = replace(
        record, qfrc_actuator=None, contact_force=None, contact_point=None, sites=(),
        recorded_markers=None, fitted_markers=None,
    )  # fmt: skip
    time = record.motion.time
    n, on = len(time), np.ones(len(time), dtype=bool)
    signals = {
        "tasks.names": np.array(["floor", "contact", "swing heel r", "centre of mass", "posture"]),
        "tasks.level": np.array([1, 2, 3, 4, 5]),
        "tasks.meanings": np.array(["Keeps up.", "Holds.", "Leads.", "Carries.", "Draws."]),
        "tasks.active": np.stack([on, on, time < 0.4, on, on], axis=1),
        "tasks.residual": np.outer(np.ones(n), [0.0, 1e-12, 1e-3, 1.0, 100.0]),
        "phase.span": np.array([[0.0, 0.4], [0.4, 0.5], [0.5, time[-1]]]),
        "phase.kind": np.array(["single", "double", "single"]),
        "phase.swing": np.array(["r", "l", "l"]),
        "posture.end": np.array([0.2, 0.4, 0.5, time[-1]]),
        "contact.span": np.array([[0.0, 0.5], [0.4, time[-1]]]),
        "contact.place": np.array(["heel_l", "heel_r"]),
    }
    others = {}
    if forces:
        beside = {}
        if measured:
            seen = np.stack([record.foot(side).force for side in "rl"], axis=1) * 0.9
            seen[150:] = np.nan
            names = ("knee_angle_r", "ankle_angle_l")
            moment = np.stack([record.torque(h) for h in names], axis=1) / record.human.mass
            beside = {
                "measured.force": seen,
                "measured.moment": 1.1 * moment,
                "measured.moment_names": np.array(names),
            }
        others["forces"] = replace(record, signals=beside, recorded_markers=None,
                                   fitted_markers=None)  # fmt: skip
    figures = {"tasks": "default", "rom_error_mean_deg": 2.34, "sole_lowest_mm": -1.2}
    return Run(
        replace(bare, signals=signals), "reproduce", title="Walk, from tasks", figures=figures,
        others=others,
    )  # fmt: skip


def solved(record: Record, *, bad: bool = False, iterations: int = 12) -> Run:
    """A run of ``synthesize``: planned contact on every site of the feet, a solver, a verdict."""
    human, time = record.human, record.motion.time
    sites = foot_sites(human)
    planned = np.zeros((len(time), len(sites)), dtype=bool)
    force = np.zeros((len(time), len(sites), 3))
    for k, side in enumerate("rl"):
        mine = [i for i, site in enumerate(sites) if site.side == side]
        standing = (time / STRIDE + (0.5 if side == "l" else 0.0)) % 1 < 0.62
        planned[np.ix_(standing, mine)] = True
        assert record.contact_force is not None
        force[:, mine] = record.contact_force[:, k, None] / len(mine) * standing[:, None, None]
    from plantigrade.pages.sections.contacts import site_points

    bare = replace(
        record, sites=sites, contact_force=force, contact_point=None, contact_planned=planned,
        references={}, recorded_markers=None, fitted_markers=None,
    )  # fmt: skip
    point = np.where(planned[..., None], site_points(bare), np.nan)
    half = iterations // 2
    history = np.column_stack(
        [
            np.repeat([0, 1], [half, iterations - half]),
            np.arange(iterations),
            np.linspace(9, 3, iterations),
            np.logspace(0, -9, iterations),
            np.logspace(1, -6, iterations),
        ]
    )
    signals = {
        "check.quantity": np.array(CHECKED),
        "check.value": np.array([0.4, 1.2, 57.7 if bad else 5.0, -3.0]),
        "check.limit": np.array([1.0, 3.0, 10.0, np.inf]),
        "check.time": np.array([0.31, np.nan, 0.5, 0.6]),
        "check.where": np.array(["", "foot_heel_back_medial_r", "knee_angle_r", ""]),
        "check.side": np.array(["", "r", "r", ""]),
        "check.unit": np.array(["% of body weight", "mm", "°", "mm"]),
        "check.bad": np.array([False, False, bad, False]),
        "check.findings": np.array(["the knee bends too far"] if bad else [], dtype=np.str_),
        "solver.broken": np.array(["z of toe is 3 mm off"] if bad else [], dtype=np.str_),
        "solver.stage_names": np.array(["coarse", "fine"]),
        "solver.stage_solvers": np.array(["interior-point", "ipopt"]),
        "solver.stage_status": np.array(["solved", "solved"]),
        "solver.stage_nodes": np.array([21, 41]),
        "solver.history": history,
        "solver.history_worst": np.array(["dynamics_3"] * iterations),
    }
    return Run(
        replace(bare, contact_point=point, signals=signals),
        "synthesize",
        title="Walk",
        sentence="A walk from the task alone.",
        status="a joint beyond its range" if bad else "ok",
        figures={"walking_speed_m_s": 1.25, "displacement_m": 5.0},
    )
