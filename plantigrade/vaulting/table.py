r"""Contact model of the vaulting table: nonlinear springs with dampers ([Cheng2009]_, Eq. 3).

.. math:: F = S D^2 + K D V

after [King2005]_, with the displacement :math:`D` of the hands and its rate :math:`V`, vertically
and horizontally.

**Ambiguities of the report.** The exponent of its equation is misprinted, so it is unclear whether
stiffness or damping is multiplied by :math:`D^2`; here it is the stiffness, because the text calls
the spring nonlinear. Both readings give zero force at first touch. The report uses one "joint"
displacement and velocity for both directions; here each direction has its own, and

* the vertical force is never negative; the hands leave when it becomes zero;
* friction limits the horizontal force to :math:`\mu F_z \tanh(F / (\mu F_z))`.

The parameters, which the report lacks, are estimates that give the measured contact times of such
vaults. Wrists and shoulder girdle are not modelled, and the table includes their compliance.
"""

from dataclasses import dataclass
from typing import Any

from plantigrade.bounds import Bounded


@dataclass(frozen=True, kw_only=True)
class VaultingTable(Bounded):
    """A vaulting table.

    Raises:
        ParameterError: If a value is out of range.
    """

    activity = "a vaulting table"
    ranges = {
        "table_height": (0.5, 2.0, "m"),
        "stiffness": (10, 1e5, "kN/m²"),
        "damping": (0, 1e4, "kN s/m²"),
        "shear_stiffness": (0, 1e5, "kN/m²"),
        "shear_damping": (0, 1e4, "kN s/m²"),
        "grip": (0, 5, ""),
    }

    table_height: float = 1.35
    """Height of the table [m]; 1.35 in men's competition."""
    stiffness: float = 150.0
    """Vertical stiffness under both hands [kN/m²]."""
    damping: float = 3.0
    """Vertical damping [kN s/m²]."""
    shear_stiffness: float = 150.0
    """Horizontal stiffness [kN/m²]."""
    shear_damping: float = 3.0
    """Horizontal damping [kN s/m²]."""
    grip: float = 1.0
    """Coefficient of friction of the hands on the table."""

    def force(self, x: Any, z: Any, vx: Any, vz: Any, ca: Any) -> tuple[Any, Any]:
        """Return horizontal and vertical force on both hands [N].

        Args:
            x: Forward displacement of the hands since touchdown [m].
            z: Height of the hands above the table [m].
            vx: Forward velocity of the hands [m/s].
            vz: Upward velocity of the hands [m/s].
            ca: ``numpy`` or ``casadi``.
        """
        depth = ca.fmax(-z, 0.0)
        normal = ca.fmax(1e3 * depth * (self.stiffness * depth - self.damping * vz), 0.0)
        shear = -1e3 * ca.fabs(x) * (self.shear_stiffness * x + self.shear_damping * vx)
        max_shear = self.grip * normal
        return max_shear * ca.tanh(shear / (max_shear + 1e-9)), normal
