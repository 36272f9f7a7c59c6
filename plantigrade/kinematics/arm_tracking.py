"""Tracking of markers with shoulder angles in the anatomical branch.

A fit that starts with an arm overhead may take the other triple, follow its markers with it until a
limit stops it, and unwind within a few frames. Shoulders are therefore tracked without limits, from
the best of several initial guesses. The triples are chosen afterwards for the whole trial: those
nearest to the usual range, within the limits and smooth from frame to frame, by dynamic
programming. A frame is solved again where none is within the limits.
"""

from itertools import product

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.inverse import InverseKinematics, track
from plantigrade.kinematics.shoulders import (
    arm_starts,
    arms_of,
    equivalent_angles,
    in_range,
    in_usual_branch,
    range_excess,
)
from plantigrade.motion.filters import interpolate

RANGE_WEIGHT = 0.02  # [m] RMS marker error equivalent to 1 rad beyond the usual range
LIMIT_WEIGHT = 100.0  # [1] cost of exceeding a limit relative to exceeding the usual range
CHANGE_WEIGHT = 50.0
"""Cost of a change between frames relative to the same excess over the usual range [1]."""
FREE_RANGE = 4 * np.pi  # [rad] limit of a shoulder angle during tracking


def track_arms(
    solver: InverseKinematics,
    measured: Float[Array, "n_frames n_points 3"],
    start: Float[Array, " nq"],
) -> tuple[Float[Array, "n_frames nq"], Float[Array, "n_frames n_points"]]:
    """Solve all frames like :func:`~plantigrade.kinematics.inverse.track`, with arms in one branch.

    Args:
        measured: World positions over time [m]; NaN where not measured.
        start: Configuration to start the first frame from.
    """
    arms = arms_of(solver.points.human)
    if not arms or not len(measured):
        return track(solver, measured, start)
    low, high = solver.low, solver.high
    start = best_start(solver, measured[0], start)
    solver.low, solver.high = low.copy(), high.copy()
    hinges = np.concatenate(arms)
    solver.low[hinges], solver.high[hinges] = -FREE_RANGE, FREE_RANGE
    qpos, residual = track(solver, measured, start)
    solver.low, solver.high = low, high
    seen, frames = np.all(np.isfinite(measured), axis=2), np.arange(len(measured))
    for k in arms:
        determined = frames[(seen @ solver.points.moved[:, 0, 6 + np.array(k)] > 0).all(axis=1)]
        if not len(determined):
            continue
        angles = one_branch(qpos[determined][:, 7:][:, k], low[k], high[k])
        qpos[:, 7 + np.array(k)] = interpolate(frames, determined, angles)  # straight across gaps
    beyond = (qpos[:, 7:] < low) | (qpos[:, 7:] > high)
    for f in np.flatnonzero(beyond.any(axis=1)):
        solution = solver.solve(measured[f], qpos[f])
        qpos[f], residual[f] = solution.qpos, solution.residual
    return qpos, residual


def one_branch(
    angles: Float[Array, "n_frames 3"], low: Float[Array, " 3"], high: Float[Array, " 3"]
) -> Float[Array, "n_frames 3"]:
    """Return equivalent angles of a shoulder that stay in one branch, near the usual range.

    Args:
        angles: Flexion, adduction, rotation of every frame [rad], of any branch and turn.
        low: Their lower limits [rad].
        high: Their upper limits [rad].
    """
    turns = 2 * np.pi * np.array(list(product((-1, 0, 1), repeat=3)))
    near = in_range(angles)
    choices = np.concatenate(
        [near[:, None] + turns, equivalent_angles(near)[:, None] + turns], axis=1
    )
    out = np.linalg.norm(np.maximum(low - choices, 0) + np.maximum(choices - high, 0), axis=-1)
    node = range_excess(choices) ** 2 + LIMIT_WEIGHT * out**2
    keep = np.argsort(node.min(axis=0))[:12]
    choices, node = choices[:, keep], node[:, keep]
    total, came = node[0], np.zeros((len(angles), len(keep)), dtype=int)
    for f in range(1, len(angles)):
        step = choices[f][None] - choices[f - 1][:, None]  # from, to
        paths = total[:, None] + CHANGE_WEIGHT * np.einsum("ijk,ijk->ij", step, step)
        came[f] = paths.argmin(axis=0)
        total = paths.min(axis=0) + node[f]
    result = np.empty_like(angles)
    k = int(np.argmin(total))
    for f in range(len(angles) - 1, -1, -1):
        result[f] = choices[f, k]
        k = came[f, k]
    return result


def best_start(
    solver: InverseKinematics, measured: Float[Array, "n_points 3"], start: Float[Array, " nq"]
) -> Float[Array, " nq"]:
    """Return the solution of a frame from the best initial guess of the arms."""
    human = solver.points.human
    arms = arms_of(human)

    def solved(q: Array) -> tuple[float, Array]:
        solution = solver.solve(measured, q)
        seen = np.isfinite(solution.residual)
        error = float(np.mean(solution.residual[seen] ** 2)) if seen.any() else 0.0
        out = sum(float(range_excess(solution.qpos[7:][k])) ** 2 for k in arms)
        return error + RANGE_WEIGHT**2 * out, solution.qpos

    best = solved(in_usual_branch(human, start))
    for sides in ("rl", *SIDES):  # both alike, then each with the best of the other
        others = [solved(q) for q in arm_starts(human, best[1], sides)]
        best = min([best, *others], key=lambda one: one[0])
    return best[1]
