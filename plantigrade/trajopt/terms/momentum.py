r"""Cost of the whole body's angular momentum about its centre of mass."""

from dataclasses import dataclass

import numpy as np

from plantigrade.constants import GRAVITY
from plantigrade.contact.plan import path_heading
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.terms.term import Term

ROW_SCALE = 100.0
"""Scale of a row, in hundredths of m √g l^1.5; the peaks of a walk are a few units."""


@dataclass(frozen=True)
class AngularMomentum(Term):
    r"""Cost :math:`\int \sum_i w_i \Lambda_i^2 dt`, :math:`\Lambda = 100 L / (m \sqrt{g} l^{1.5})`.

    :math:`L` is the angular momentum about the centre of mass, :math:`l` the length of the legs.
    In walking people cancel about 70 % of it between their segments in the frontal, 80 % about the
    vertical and 95 % in the sagittal plane [Herr2008]_. Axes go with the way: forward, to
    the left, up.
    """

    forward: float = 0.1  #: Weight about the way, frontal plane [1/s]
    sideways: float = 0.0  #: Weight about the axis to the left, sagittal plane [1/s]
    upward: float = 0.5  #: Weight about the vertical [1/s]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the components."""
        d = b.body.human.dimensions
        leg = d.leg_length
        unit = b.body.symbolic.mass * float(np.sqrt(GRAVITY)) * leg**1.5 / ROW_SCALE

        def expression(ca, q, v, a, u, p):
            x, y, z = ca.vertsplit(b.body.symbolic.momentum()(q, v)[1] / unit)
            return ca.vertcat(p[0] * x + p[1] * y, p[0] * y - p[1] * x, z)

        function = b.body.function("angular momentum", expression, 2)
        names = tuple(f"angular momentum {x}" for x in ("forward", "to the left", "upward"))
        way = path_heading(b.plan, b.nodes)
        way = np.stack([np.cos(way), np.sin(way)], axis=1)
        unit_name = "% of m sqrt(g) l^1.5"
        family = b.add(
            ConstraintFamily.free("angular momentum", function, names, len(b.nodes), way, unit_name)
        )
        b.penalise(family, 2.0 * np.array([self.forward, self.sideways, self.upward]))
