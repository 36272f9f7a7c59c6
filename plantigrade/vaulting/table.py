r"""The vaulting table under the hands: nonlinear springs with dampers ([Cheng2009]_, Eq. 3).

.. math:: F = S D^2 + K D V

after [King2005]_, with the displacement :math:`D` of the hands and its rate :math:`V`, vertically
and horizontally.

**Where the report is unclear.** The exponent of its equation is misprinted: whether stiffness or
damping goes with :math:`D^2` cannot be told. Here it is the stiffness: the spring is said to be
nonlinear. Both readings give no force at first touch. It speaks of "joint" displacement and
velocity, and of one force in both directions; here each direction has its own, and

* a table does not pull: vertical force is never negative, and where it becomes zero the hands have
  left;
* a hand slips rather than pull sideways by more than friction can hold: horizontal force follows
  :math:`\mu F_z \tanh(F / (\mu F_z))`.

It gives no numbers. Those here are estimates: soft enough that hands stay on the table for the
time measured in vaults of this kind, for in a model without wrists and shoulder girdle the table
has to give what these give.
"""

from dataclasses import dataclass
from typing import Any

from plantigrade.bounds import Bounded


@dataclass(frozen=True, kw_only=True)
class Table(Bounded):
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
            x: How far the hands are ahead of where they touched down [m].
            z: How far they are above the table [m].
            vx: Their velocity forward [m/s].
            vz: Their velocity upward [m/s].
            ca: ``numpy`` or ``casadi``.
        """
        deep = ca.fmax(-z, 0.0)
        up = ca.fmax(1e3 * deep * (self.stiffness * deep - self.damping * vz), 0.0)
        far = ca.fabs(x)
        back = -1e3 * far * (self.shear_stiffness * x + self.shear_damping * vx)
        held = self.grip * up
        return held * ca.tanh(back / (held + 1e-9)), up
