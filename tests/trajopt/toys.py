"""Small problems that need no person: any function of a node's states makes rows."""

import casadi as ca
import numpy as np

from plantigrade.trajopt import ConstraintFamily, PeriodicClosure, Problem
from plantigrade.trajopt.splines.basis import Basis
from plantigrade.trajopt.splines.knots import clamped_knots, periodic_knots
from plantigrade.trajopt.splines.polynomial import PolynomialBasis
from plantigrade.trajopt.splines.trigonometric import TrigonometricBasis

BASES = {"trigonometric": TrigonometricBasis, "polynomial": PolynomialBasis}


def inputs(nv: int, nu: int = 0, n_parameters: int = 0) -> list:
    """Symbols of q, qd, qdd, u, p."""
    sizes = zip(("q", "qd", "qdd", "u", "p"), (nv, nv, nv, nu, n_parameters), strict=True)
    return [ca.SX.sym(name, n) for name, n in sizes]


def rows(name: str, symbols: list, expression, n_nodes: int, parameters=None) -> ConstraintFamily:
    """Rows without limits or cost."""
    function = ca.Function("rows", symbols, [expression])
    names = tuple(f"{name} {i}" for i in range(expression.shape[0]))
    return ConstraintFamily.free(name, function, names, n_nodes, parameters)


def cubic(nodes, basis: str = "polynomial", *, periodic: bool = False) -> Basis:
    """The basis whose knots are the nodes; of a periodic one the end is given too."""
    knots = periodic_knots if periodic else clamped_knots
    return BASES[basis](3, knots(np.asarray(nodes), 3), periodic=periodic)


def uneven(n: int, seed: int, duration: float = 1.3) -> np.ndarray:
    """Times of unequal distances, start and end among them [s]."""
    steps = np.random.default_rng(seed).uniform(0.3, 1.0, n - 1)
    return np.concatenate([[0.0], np.cumsum(steps)]) * duration / steps.sum()


def shape(n: int, seed: int, basis: str, turns: str | None) -> Problem:
    """A problem without rows: three coordinates, two unknowns that are free here and there.

    Args:
        n: Nodes, the end among them.
        seed: Of everything.
        basis: Name of the basis.
        turns: None for a motion that ends, ``"mirror"`` for one whose second coordinate mirrors
            the first, ``"ring"`` for one that hands its coordinates round.
    """
    rng = np.random.default_rng(seed)
    ends = uneven(n, seed)
    nodes = ends if turns is None else ends[:-1]
    lower = np.full((len(nodes), 2), -2.0)
    upper = np.full((len(nodes), 2), 3.0)
    fixed = rng.random(lower.shape) < 0.3
    lower[fixed] = upper[fixed] = rng.normal(size=fixed.sum())
    closure = None
    if turns is not None:
        source, shift = {
            "mirror": ([1, 0, 2], [0.4, 0.4, 0.0]),
            "ring": ([1, 2, 0], [0.0, 0.0, 0.0]),
        }[turns]
        closure = PeriodicClosure(
            np.array(source),
            np.array([1.0, 1.0, -1.0]),
            np.array(shift),
            np.array([1, 0]),
            np.array([-1.0, 1.0]),
        )
    return Problem(
        cubic(ends, basis, periodic=turns is not None),
        nodes,
        ("a", "b", "c"),
        (),
        ("f", "g"),
        lower,
        upper,
        rng.uniform(0.5, 2.0, (len(nodes) if turns else len(nodes) - 1, 2)),
        closure,
        rng.uniform(0.1, 1.0, 3) * 1e-4,
    )


def mass_on_a_line(n: int = 21, *, twice: bool = False) -> Problem:
    """A mass goes from 0 to 1 in 1 s, from rest to rest, with the least sum of squared force.

    Args:
        n: Nodes.
        twice: Whether the law of motion is asked for twice, in other units.
    """
    nodes = np.linspace(0.0, 1.0, n)
    symbols = inputs(1, 1)
    q, qd, qdd, u, _ = symbols
    state = rows("state", symbols, ca.vertcat(q, qd), n)
    state.lower[0] = state.upper[0] = 0.0
    state.lower[-1] = state.upper[-1] = (1.0, 0.0)
    law = rows("law", symbols, ca.vertcat(u - qdd, *([3 * (u - qdd)] if twice else [])), n)
    law.lower[:] = law.upper[:] = 0.0
    force = rows("force", symbols, u, n)
    force.weight[:] = 1.0
    force.weight[[0, -1]] = 0.5  # the trapezoid of the integral
    limits = np.full((n, 1), 100.0)
    smooth = np.zeros((n - 1, 1))
    return Problem(
        cubic(nodes), nodes, ("x",), (state, law, force), ("f",), -limits, limits, smooth
    )


def pendulum(n: int = 41, *, duration: float = 4.0, strength: float = 4.0) -> Problem:
    """A pendulum (length 1 m, mass 1 kg) swings up from hanging to upright, from rest to rest.

    Args:
        n: Nodes.
        duration: How long it takes [s].
        strength: Largest torque [N m]; 9.81 would hold it anywhere.
    """
    nodes = np.linspace(0.0, duration, n)
    symbols = inputs(1, 1)
    q, qd, qdd, u, _ = symbols
    state = rows("state", symbols, ca.vertcat(q, qd), n)
    state.lower[0] = state.upper[0] = 0.0
    state.lower[-1] = state.upper[-1] = (np.pi, 0.0)
    law = rows("law", symbols, qdd + 9.81 * ca.sin(q) - u, n)
    law.lower[:] = law.upper[:] = 0.0
    torque = rows("torque", symbols, u, n)
    torque.weight[:] = 2 * duration / n
    limits = np.full((n, 1), strength)
    return Problem(
        cubic(nodes),
        nodes,
        ("angle",),
        (state, law, torque),
        ("torque",),
        -limits,
        limits,
        np.full((n - 1, 1), 1e-3),
    )


def swing(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """A crude guess of a pendulum's way up: there and back, then up."""
    t = problem.nodes / problem.nodes[-1]
    angle = np.where(t < 0.5, -1.2 * np.sin(2 * np.pi * t), np.pi * np.sin(np.pi * (t - 0.5)) ** 2)
    return problem.basis.fit(problem.nodes, angle[:, None], smoothing=1e-9), np.zeros((len(t), 1))
