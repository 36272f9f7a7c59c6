r"""How much torque a muscle gives by the speed of its joint ([Cheng2009]_, Eq. 2).

.. math:: h(\omega) = \frac{\omega_0 - \omega}{\omega_0 + \Gamma\omega}
    \;\text{ for } \omega/\omega_0 \le 1, \quad 0 \text{ beyond},

with :math:`\omega_0 = \pm 20` rad/s, whose sign is that of the effort, and :math:`\Gamma = 2.5`:
half of the strength is left at 4.4 rad/s. (Extensors and flexors of hips and knees had half at 3.2
to 5.2 rad/s in [Anderson2007]_.)

**An error in the report.** A lengthening muscle has :math:`\omega/\omega_0 < 0`, where the formula
has a pole at :math:`-1/\Gamma`, at 8 rad/s, which joints reach in a vault. Lengthening muscles
therefore follow a hyperbola with the same slope at rest and the limit :math:`e = 1.4`
[Yeadon2006]_:

.. math:: h = e - \frac{e - 1}{1 - s\,\omega/\omega_0}, \qquad s = \frac{1 + \Gamma}{e - 1}.
"""

from typing import Any

import numpy as np

OMEGA_0 = 20.0  #: Maximum angular velocity of a joint under muscle torque [rad/s], from the report
GAMMA = 2.5  #: Shape parameter of the velocity factor [1], from the report
MAX_ECCENTRIC_FACTOR = 1.4
"""Maximum torque of lengthening muscle relative to isometric strength [1], [Yeadon2006]_."""


def velocity_factor(ratio: Any, ca: Any = np) -> Any:
    r"""Return :math:`h` of :math:`\omega/\omega_0`, an array or a CasADi expression.

    Example:
        >>> velocity_factor(np.array([-0.5, 0.0, 0.5, 1.0, 2.0])).round(3).tolist()
        [1.326, 1.0, 0.222, 0.0, 0.0]
    """
    up, down = ca.fmax(ratio, 0.0), ca.fmin(ratio, 0.0)
    slope = (1.0 + GAMMA) / (MAX_ECCENTRIC_FACTOR - 1.0)
    shortening = ca.fmax((1.0 - up) / (1.0 + GAMMA * up), 0.0)
    return shortening + (MAX_ECCENTRIC_FACTOR - 1.0) * (1.0 - 1.0 / (1.0 - slope * down))
