"""Data for starting another problem from a solved one, stored as signals of its Record."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solvers.result import Multipliers
from plantigrade.trajopt.tasks.task import closure_of, spline_basis

_NEEDED = ("coefficients", "forces", "nodes", "coordinates", "unknowns", "switches", "basis")


@dataclass(frozen=True, eq=False)
class WarmStart:
    """A motion to start from."""

    problem: Problem  #: Its spline, nodes and how it repeats; no rows
    coefficients: Float[Array, "n_coefficients nv"]  #: Coefficients of the spline
    forces: Float[Array, "n_nodes n_unknowns"]  #: Contact forces at nodes [body weights]
    nodes: Float[Array, " n"]  #: Times of the nodes, start and end among them [s]
    switches: Float[Array, " n_switches"]  #: Times at which contact changes [s]
    multipliers: Multipliers | None = None  #: Multipliers of the rows, if known

    @classmethod
    def of_record(cls, record: Record) -> "WarmStart":
        """Return the warm start that a Record of ``synthesize`` holds."""
        kept = record.group("spline")
        if any(name not in kept for name in _NEEDED):
            raise ParameterError(
                "cannot warm-start: the run holds no solved spline; name a folder that plantigrade "
                "synthesize wrote"
            )
        try:
            names = tuple(str(n) for n in kept["coordinates"])
            unknowns = tuple(str(n) for n in kept["unknowns"])
            nodes, period = np.asarray(kept["nodes"], float), kept.get("period")
            basis, closure = spline_basis(str(kept["basis"]), nodes, period is not None), None
            if period is not None:
                sites = [n.removeprefix("force x of ") for n in unknowns[::3]]
                way = float(period[1]), float(kept.get("aside", (0.0,))[0])
                closure = closure_of(names, sites, mirrored=bool(period[0] > 0), way=way)
            inner = nodes if closure is None else nodes[:-1]
            none = np.zeros((len(inner), len(unknowns)))
            problem = Problem(basis, inner, names, (), unknowns, none, none, none[:0], closure)
            c, u = (np.asarray(kept[n], float) for n in ("coefficients", "forces"))
            if c.shape != (basis.n_coefficients, len(names)) or u.shape != none.shape:
                raise ParameterError("coefficients and nodes do not belong together")
        except (ValueError, TypeError, IndexError) as error:
            raise ParameterError(
                f"cannot warm-start: the spline of the run is broken ({error})"
            ) from error
        multipliers = record.group("spline.multipliers")
        pushing = {name: np.asarray(value, float) for name, value in multipliers.items()}
        switches = np.asarray(kept["switches"], float)
        return cls(problem, c, u, nodes, switches, Multipliers(pushing) if pushing else None)
