"""The figures of a motion from a task: of the solver, the checker and the movement itself."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.synthesize.tasks.task import Task

if TYPE_CHECKING:
    from plantigrade.motion import GaitEvent
    from plantigrade.synthesize.solution import Synthesis
    from plantigrade.workflows.synthesize import Synthesized


def figures(made: "Synthesized") -> dict[str, Any]:
    """Return the figures of a motion: of the solver, the checker and the movement itself."""
    synthesis, s = made.synthesis, made.sampled
    problem = synthesis.problem
    last = synthesis.stages[-1].history[-1]
    found: dict[str, Any] = {
        "task": synthesis.task.name,
        "duration_s": float(s.time[-1]),
        "frames": len(s.time),
        "solver_status": synthesis.status,
        "solver_success": synthesis.success,
        "solver_stages": len(synthesis.stages),
        "iterations": synthesis.iterations,
        "solve_time_s": synthesis.seconds,
        "prepare_time_s": made.prepared,
        "objective": synthesis.objective,
        "violation_max": last.violation,
        "optimality": last.optimality,
        "nodes": len(problem.nodes),
        "unknowns": int(synthesis.c.size + problem.u_active.sum()),
        "equations": int(sum(r.equations.sum() for r in problem.rows)),
        "inequalities": int(sum(r.inequalities.sum() for r in problem.rows)),
        "tries": len(made.tried) or 1,
    }
    if made.broken:
        found["broken_rows"] = [b.sentence() for b in made.broken]
    return found | made.check.metrics() | movement_figures(made) | walk_figures(made)


def movement_figures(made: "Synthesized") -> dict[str, Any]:
    """Return how far the body moves and what that takes."""
    human, s, check = made.human, made.sampled, made.check
    weight = made.synthesis.body.weight
    power = check.tau[:, 6:] * s.qvel[:, 6:]
    total = np.abs(power).sum(axis=1)
    feet = np.array([site.side != "" for site in made.synthesis.body.sites], bool)
    vertical = s.force[:, feet, 2].sum(axis=1) / weight
    way = float(np.linalg.norm(check.com[-1, :2] - check.com[0, :2]))
    work = float(np.trapezoid(total, s.time))
    positive = float(np.trapezoid(np.maximum(power, 0.0).sum(axis=1), s.time))
    found = {
        "displacement_m": way,
        "com_lowest_m": float(check.com[:, 2].min()),
        "com_highest_m": float(check.com[:, 2].max()),
        "ground_force_max_bw": float(vertical.max()),
        "joint_work_positive_j": positive,
        "joint_work_absolute_j": work,
        "joint_power_max_w": float(np.maximum(power, 0.0).sum(axis=1).max()),
    }
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        for side in ("r", "l"):
            i = human.hinge(f"{name}_{side}")
            values = np.rad2deg(s.qpos[:, 7 + i])
            found[f"{name}_range_{side}_deg"] = float(np.ptp(values))
            torque = np.abs(check.tau[:, 6 + i]).max() / human.mass
            found[f"{name}_moment_max_{side}_nm_kg"] = float(torque)
    found |= flight_figures(made)
    if way > 0.3:
        found["cost_of_transport"] = work / (weight * way)
        found["cost_of_transport_positive"] = positive / (weight * way)
    return found


def flight_figures(made: "Synthesized") -> dict[str, Any]:
    """Return how long and how high the body flies; nothing where it always stands on something."""
    import mujoco

    s, human = made.sampled, made.human
    flies = np.flatnonzero(~s.standing.any(axis=1))
    if len(flies) < 2:
        return {}
    last = max(int(flies[0]) - 1, 0)
    data = mujoco.MjData(human.model)
    data.qpos[:], data.qvel[:] = s.qpos[last], s.qvel[last]
    mujoco.mj_forward(human.model, data)
    mujoco.mj_subtreeVel(human.model, data)
    height = made.check.com[:, 2]
    return {
        "flight_time_s": float(s.time[flies[-1]] - s.time[last]),
        "take_off_speed_m_s": float(data.subtree_linvel[1, 2]),
        "flight_rise_m": float(height[flies].max() - height[last]),
    }


def walk_figures(made: "Synthesized") -> dict[str, Any]:
    """Return the measures of a walk; nothing for other motions."""
    if not made.events:
        return {}
    from plantigrade.analyze.gait import gait_measures
    from plantigrade.analyze.trial import foot_path

    human, end = made.human, float(made.sampled.time[-1])
    time = np.linspace(0.0, end, int(np.ceil(end * 200.0)) + 1)  # an even clock
    feet = foot_path(human, made.synthesis.sample(time).qpos)
    found: dict[str, Any] = gait_measures(time, feet.heel, feet.toe, made.events).metrics()
    for key in ("treadmill", "belt_speed_m_s"):
        found.pop(key, None)
    if made.synthesis.task.plan.periodic:  # every stride is the same
        found = {k: v for k, v in found.items() if "_sd_" not in k}
    d = human.dimensions
    for name in ("thigh", "shank", "ankle_height"):
        found[f"length_{name}_m"] = float(getattr(d, name))
    return found | ground_force_figures(made) | norm_figures(made, found)


def ground_force_figures(made: "Synthesized") -> dict[str, Any]:
    """Return both peaks of the vertical force in stance and the trough between them [BW]."""
    from plantigrade.motion.cycles import cut_cycles

    weight, t = made.synthesis.body.weight, made.sampled.time
    found = {}
    for side in ("r", "l"):
        mine = np.array([site.side == side for site in made.synthesis.body.sites], bool)
        up = made.sampled.force[:, mine, 2].sum(axis=1) / weight
        rows = []
        for cycle in cut_cycles(made.events, side=side):
            if cycle.toe_off is None:
                continue
            stance = (t >= cycle.start) & (t <= cycle.toe_off)
            share = (t[stance] - cycle.start) / (cycle.toe_off - cycle.start)
            force = up[stance]
            first, second = force[share < 0.5].max(), force[share >= 0.5].max()
            a = int(np.argmax(np.where(share < 0.5, force, -1.0)))
            b = int(np.argmax(np.where(share >= 0.5, force, -1.0)))
            rows.append((first, force[a : b + 1].min(), second))
        if rows:
            for name, value in zip(
                ("peak_1", "trough", "peak_2"), np.mean(rows, axis=0), strict=True
            ):
                found[f"ground_force_{name}_{side}_bw"] = float(value)
    return found


def norm_figures(made: "Synthesized", measures: Mapping[str, Any]) -> dict[str, Any]:
    """Return how far angles of hip, knee and ankle are from published means over the cycle."""
    from plantigrade.analyze import norms
    from plantigrade.analyze.curves import gait_curves
    from plantigrade.analyze.statistics import correlation, rmse, rmse_offset_removed

    speed = measures.get("walking_speed_m_s")
    if speed is None:
        return {}
    d = made.human.dimensions
    speed_class = norms.speed_class(speed, d.thigh + d.shank + d.ankle_height)
    curves = gait_curves(made.human.model, made._record)
    found: dict[str, Any] = {}
    raw, free = [], []
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        rows = curves.angles.get(f"{name}_r", np.empty((0, 1)))
        if not len(rows):
            return {}
        band = norms.norm(name, speed_class)
        theirs = np.interp(curves.percent, band.percent, band.mean)
        ours = np.nanmean(rows, axis=0)
        raw.append(rmse(ours, theirs))
        free.append(rmse_offset_removed(ours, theirs))
        found[f"norm_rmse_{name}_deg"] = raw[-1]
        found[f"norm_correlation_{name}"] = correlation(ours, theirs)
    found["norm_rmse_mean_deg"] = float(np.mean(raw))
    found["norm_rmse_offset_removed_mean_deg"] = float(np.mean(free))
    return found


def gait_events(synthesis: "Synthesis", end: float) -> "tuple[GaitEvent, ...]":
    """Return heel strikes and toe offs of a walk from its plan, up to its end [s]."""
    from plantigrade.motion import GaitEvent
    from plantigrade.synthesize.tasks.walking_plan import unrolled

    plan = synthesis.task.plan
    if not is_walk(synthesis.task):
        return ()
    laps = int(np.ceil(end / plan.duration)) + 2
    stances = unrolled(plan, after=laps)
    first = -1e-9 if plan.periodic else 1e-9  # a foot that stands from the start did not strike
    last = end + 1e-9 if plan.periodic else end - 1e-9
    events = []
    for s in stances:
        for time, kind in ((s.strike, "heel_strike"), (s.off, "toe_off")):
            if first < time < last:
                events.append(GaitEvent(min(max(time, 0.0), end), s.footprint.side, kind))
    return tuple(sorted(events, key=lambda e: e.time))


def is_walk(task: Task) -> bool:
    """Return whether feet step in turns, so that there are strides to measure."""
    plan = task.plan
    if plan.periodic:
        return True
    struck = [s for s in sorted(plan.stances, key=lambda s: s.strike) if s.strike > 0]
    sides = [s.footprint.side for s in struck]
    return (
        task.name.startswith("walk")
        and len(sides) > 1
        and all(a != b for a, b in zip(sides[:-1], sides[1:], strict=True))
    )
