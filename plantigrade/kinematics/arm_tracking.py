"""Markers followed with shoulders that keep the anatomical one of their two triples of angles.

A fit that starts with an arm overhead may take the other triple, follow its markers with it until a
limit stops it, and unwind within a few frames. Shoulders are therefore followed without limits,
from the best of several ways to hold the arms, and the triple is chosen afterwards, for the whole
trial: the one that leaves the usual range and the limits least, and leaps least from frame to
frame, by dynamic programming over the equivalent triples. Only where none is within the limits a
frame is solved again.
"""

from itertools import product

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.inverse import InverseKinematics, track
from plantigrade.kinematics.shoulders import (
    arms_of,
    astray,
    held_otherwise,
    in_branch,
    in_range,
    other_triple,
)

ASTRAY = 0.02
"""What an arm that is out of its usual range by 1 rad counts as: so much marker error [m], root
mean square over all markers."""
LIMIT = 100.0
"""A limit that is left counts so many times as much as the usual range."""
LEAP = 50.0
"""A leap from one frame to the next counts as much as as many frames out of range by its size."""
FREE = 4 * np.pi  # range of a shoulder angle while it is followed [rad]


def track_arms(
    solver: InverseKinematics,
    measured: Float[Array, "n_frames n_points 3"],
    start: Float[Array, " nq"],
    progress=None,
) -> tuple[Float[Array, "n_frames nq"], Float[Array, "n_frames n_points"]]:
    """Solve all frames as :func:`~plantigrade.kinematics.inverse.track` does, arms in branch.

    Args:
        solver: The inverse kinematics.
        measured: World positions over time [m]; NaN where not measured.
        start: Configuration to start the first frame from.
        progress: Called with the number of frames done, now and then.
    """
    arms = arms_of(solver.points.human)
    if not arms or not len(measured):
        return track(solver, measured, start, progress)
    low, high = solver.low, solver.high
    start = best_start(solver, measured[0], start)
    solver.low, solver.high = low.copy(), high.copy()
    hinges = np.concatenate(arms)
    solver.low[hinges], solver.high[hinges] = -FREE, FREE
    qpos, residual = track(solver, measured, start, progress)
    solver.low, solver.high = low, high
    seen, frames = np.all(np.isfinite(measured), axis=2), np.arange(len(measured))
    for k in arms:
        told = frames[(seen @ solver.points.moved[:, 0, 6 + np.array(k)] > 0).all(axis=1)]
        if not len(told):
            continue
        angles = one_branch(qpos[told][:, 7:][:, k], low[k], high[k])
        for i, column in zip(k, angles.T, strict=True):  # straight across gaps
            qpos[:, 7 + i] = np.interp(frames, told, column)
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
    choices = np.concatenate([near[:, None] + turns, other_triple(near)[:, None] + turns], axis=1)
    out = np.linalg.norm(np.maximum(low - choices, 0) + np.maximum(choices - high, 0), axis=-1)
    node = astray(choices) ** 2 + LIMIT * out**2
    keep = np.argsort(node.min(axis=0))[:12]
    choices, node = choices[:, keep], node[:, keep]
    total, came = node[0], np.zeros((len(angles), len(keep)), dtype=int)
    for f in range(1, len(angles)):
        step = choices[f][None] - choices[f - 1][:, None]  # from, to
        paths = total[:, None] + LEAP * np.einsum("ijk,ijk->ij", step, step)
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
    """Return the solution of a frame from the best of several ways to hold the arms."""
    human = solver.points.human
    arms = arms_of(human)

    def solved(q: Array) -> tuple[float, Array]:
        solution = solver.solve(measured, q)
        seen = np.isfinite(solution.residual)
        error = float(np.mean(solution.residual[seen] ** 2)) if seen.any() else 0.0
        out = sum(float(astray(solution.qpos[7:][k])) ** 2 for k in arms)
        return error + ASTRAY**2 * out, solution.qpos

    best = solved(in_branch(human, start))
    for sides in ("rl", *SIDES):  # both alike, then each beside the best of the other
        others = [solved(q) for q in held_otherwise(human, best[1], sides)]
        best = min([best, *others], key=lambda one: one[0])
    return best[1]
