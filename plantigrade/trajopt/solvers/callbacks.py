"""A sparse program as the functions that a solver of CasADi calls.

A CasADi solver takes the functions it needs by name (``nlp_f``, ``nlp_jac_g``, …) from its option
``cache``; what it finds there it does not derive itself.
"""

import time as clock
from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

from plantigrade.arrays import Array
from plantigrade.trajopt.solvers.result import Iterate
from plantigrade.trajopt.solvers.sparse_program import SparseProgram


class ArrayFunction(ca.Callback):
    """A function of arrays that CasADi can call.

    An input has a name and a pattern, an output also what returns its nonzeros from those of all
    inputs.
    """

    def __init__(
        self,
        name: str,
        inputs: Sequence[tuple[str, ca.Sparsity]],
        outputs: Sequence[tuple[str, ca.Sparsity, Callable[..., Array | float]]],
    ):
        ca.Callback.__init__(self)
        self._inputs, self._outputs = inputs, outputs
        self.construct(name, {})

    def get_n_in(self) -> int:
        """Return the number of inputs."""
        return len(self._inputs)

    def get_n_out(self) -> int:
        """Return the number of outputs."""
        return len(self._outputs)

    def get_name_in(self, i: int) -> str:
        """Return the name of an input."""
        return self._inputs[i][0]

    def get_name_out(self, i: int) -> str:
        """Return the name of an output."""
        return self._outputs[i][0]

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the pattern of an input."""
        return self._inputs[i][1]

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the pattern of an output."""
        return self._outputs[i][1]

    def has_eval_buffer(self) -> bool:
        """Return that arrays are passed as buffers."""
        return True

    def eval_buffer(self, arg, res) -> int:
        """Write the outputs that are requested; absent inputs are zero."""
        given = [
            np.zeros(pattern.nnz()) if memory is None else np.frombuffer(memory, dtype=float)
            for memory, (_, pattern) in zip(arg, self._inputs, strict=True)
        ]
        for memory, (_, _, evaluate) in zip(res, self._outputs, strict=True):
            if memory is not None:
                np.frombuffer(memory, dtype=float)[:] = evaluate(*given)
        return 0


def functions_of(program: SparseProgram, *, symmetric: bool) -> dict[str, ArrayFunction]:
    """Return all functions a solver may request, by the solver's names.

    Hessians have the upper triangle alone, or both if they are to be ``symmetric``.
    """
    n, m = program.n_variables, len(program.lower)
    x, p = ("x", ca.Sparsity.dense(n, 1)), ("p", ca.Sparsity.dense(0, 1))
    number, row = ca.Sparsity.dense(1, 1), ca.Sparsity.dense(1, n)
    J = ca.Sparsity.triplet(m, n, *(each.tolist() for each in program.jacobian_pattern))
    f = ("f", number, lambda x, p: program.objective(x))
    g = ("g", ca.Sparsity.dense(m, 1), lambda x, p: program.constraints(x))
    gradient = ("grad_f_x", ca.Sparsity.dense(n, 1), lambda x, p: program.gradient(x))
    jacobian = ("jac_g_x", J, lambda x, p: program.jacobian(x))
    made = {
        "nlp": ArrayFunction("nlp", [x, p], [f, g]),
        "nlp_f": ArrayFunction("nlp_f", [x, p], [f]),
        "nlp_g": ArrayFunction("nlp_g", [x, p], [g]),
        "nlp_grad_f": ArrayFunction("nlp_grad_f", [x, p], [f, gradient]),
        "nlp_jac_g": ArrayFunction("nlp_jac_g", [x, p], [g, jacobian]),
        "nlp_jac_fg": ArrayFunction(
            "nlp_jac_fg", [x, p], [f, ("jac_f_x", row, gradient[2]), g, jacobian]
        ),
    }
    i, j = program.hessian_pattern
    entries = np.arange(len(i))
    if symmetric:
        off = i != j
        i, j = np.concatenate([i, j[off]]), np.concatenate([j, i[off]])
        entries = np.concatenate([entries, entries[off]])
    order = np.lexsort((i, j))
    H = ca.Sparsity.triplet(n, n, i[order].tolist(), j[order].tolist())
    entries = entries[order]

    def hessian(x: Array, p: Array, cost: Array, multipliers: Array) -> Array:
        return program.hessian(x, float(cost[0]), multipliers)[entries]

    lagrangian = [x, p, ("lam_f", number), ("lam_g", ca.Sparsity.dense(m, 1))]
    made["nlp_hess_l"] = ArrayFunction("nlp_hess_l", lagrangian, [("hess_gamma_x_x", H, hessian)])
    return made


class IterationWatch(ArrayFunction):
    """Iteration callback of CasADi that stores the best point and stops on request.

    Attributes:
        best: Violation (at least ``feasibility``: below, the cheaper point is the better one),
            objective and variables of the best point.
        objective: Objective of every iteration.
        violation: Violation of every iteration.
        started: When the solver was started [s].
        stop: Whether the solver is to stop.
    """

    def __init__(
        self,
        program: SparseProgram,
        feasibility: float,
        callback: Callable[[Iterate], bool | None] | None,
    ):
        self._program, self._feasibility, self._callback = program, feasibility, callback
        self.best: tuple[float, float, Array] | None = None
        self.objective: list[float] = []
        self.violation: list[float] = []
        self.started, self.stop = clock.perf_counter(), False
        n, m = program.n_variables, len(program.lower)
        sizes = {"x": n, "f": 1, "g": m, "lam_x": n, "lam_g": m, "lam_p": 0}
        outputs = [ca.nlpsol_out(i) for i in range(ca.nlpsol_n_out())]  # of the solver
        super().__init__(
            "watch",
            [(name, ca.Sparsity.dense(sizes[name], 1)) for name in outputs],
            [("ret", ca.Sparsity.dense(1, 1), self._note)],
        )

    def _note(self, x: Array, f: Array, g: Array, *_: Array) -> float:
        """Note one iteration; return 1 to stop."""
        cost, off = float(f[0]), float(np.abs(self._program.excess(g)).max(initial=0.0))
        self.objective.append(cost)
        self.violation.append(off)
        rank = (max(off, self._feasibility), cost)
        if np.isfinite(off) and (self.best is None or rank < self.best[:2]):
            self.best = (*rank, x.copy())
        if not self.stop and self._callback is not None:
            number, seconds = len(self.objective) - 1, clock.perf_counter() - self.started
            try:
                self.stop = bool(self._callback(Iterate(number, cost, off, seconds=seconds)))
            except KeyboardInterrupt:
                self.stop = True
        return float(self.stop)
