"""Steps towards feasibility alone, where those of the optimiser are not accepted."""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.synthesize.solvers.kkt import factorised, solved
from plantigrade.synthesize.transcription.evaluation import Evaluation

STIFF = 1e6
"""Weight of linear equations beside the distance from a guess."""


def restored(e: Evaluation, x: Array) -> Array | None:
    """Return a point with less violation, by damped Gauss-Newton steps; None if none is found."""
    damping, here = 1e-2, x
    first = size = e.squared_violation(e.values(x))
    for _ in range(15):
        e.linearise(here)
        off = [np.sign(b.r - b.lower) * b.violation(b.r) for b in e.blocks]
        violated = [np.where(each != 0.0, 1.0, 0.0) for each in off]
        band = e.t.assemble(e.hessians(here, violated, None))
        gradient = e.pull_back(off)
        for _ in range(8):
            factor = factorised(band, damping)
            if factor is None:
                return None
            trial = here - solved(factor, gradient)
            after = e.squared_violation(e.values(trial))
            if after < size:
                here, size, damping = trial, after, max(damping / 4, 1e-8)
                break
            damping *= 6
        else:
            break
        if size < 1e-4 * first:
            break
    return here if size < 0.5 * first else None


def onto_linear_equations(e: Evaluation, x: Array, feasibility: float) -> Array:
    """Return the point nearest to ``x``, linearised last, that satisfies linear equations.

    Where they are violated by no more than ``feasibility``, that is ``x`` itself.
    """
    weights = [np.where(b.equations & b.linear, STIFF, 0.0) for b in e.blocks]
    aims = [np.where(b.equations, b.lower, 0.0) for b in e.blocks]
    missing = [w * (b.r - aim) for b, w, aim in zip(e.blocks, weights, aims, strict=True)]
    if not any(np.abs(m).max(initial=0.0) > STIFF * feasibility for m in missing):
        return x
    factor = factorised(e.t.assemble(e.hessians(x, weights, None), smooth=0.0), 1.0)
    return x if factor is None else x - solved(factor, e.pull_back(missing))
