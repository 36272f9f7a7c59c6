r"""Passive joint moments of ligaments and soft tissue.

For the sagittal joints of the legs the double exponentials of [Riener1999]_ (Eqs. 1 to 3, mean of
ten healthy men; ankle dorsiflexion :math:`\varphi_A`, knee flexion :math:`\varphi_K` and hip
flexion :math:`\varphi_H` in degrees, moments positive in these directions):

.. math::
    M_A &= e^{-7.9763 - 0.1949\varphi_A + 0.0008\varphi_K}
        - e^{2.1016 + 0.0843\varphi_A - 0.0176\varphi_K} + 1.792 \\
    M_K &= e^{1.800 + 0.0460\varphi_A - 0.0352\varphi_K + 0.0217\varphi_H}
        - e^{-3.971 + 0.0004\varphi_A + 0.0495\varphi_K - 0.0128\varphi_H} - 4.820
        + e^{2.220 - 0.150\varphi_K} \\
    M_H &= e^{1.4655 - 0.0034\varphi_K - 0.0750\varphi_H}
        - e^{1.3403 - 0.0226\varphi_K + 0.0305\varphi_H} + 8.072

Other joints have a linear stiffness about their zero (:func:`linear_stiffness`) and all joints a
linear damping (:data:`DAMPING`); numbers without a cited measurement are estimates. Moments scale
with mass times height, like strengths.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.data_files import named_numbers
from plantigrade.models.coordinates import REFERENCE_HEIGHT, REFERENCE_MASS
from plantigrade.side_names import split_side

STIFFNESS = named_numbers("plantigrade.dynamics", "stiffness.csv")
"""Stiffness about zero [N m/rad] for the reference mass and height, of trunk and neck as a whole.

Near upright, the lumbar spine resists bending sideways by 14 N m/rad (first quarter of its range in
living people [Watt2022]_) and the thoracic spine with its ribs by 94 (cadavers, neutral zones of
three parts in series [Mannen2018]_): 12 in series. Both resist flexion less; turning is an
estimate, the thoracic spine alone resists it by 23."""
IN_SERIES = {
    "trunk": ("lumbar", "lower_thorax", "thorax"),
    "neck": ("lower_neck", "upper_neck", "neck"),
}
"""Part of the spine → the joints into which joint sets divide it."""
DAMPING: Mapping[str, float] = {"lumbar": 2.0, "lower_thorax": 2.0, "thorax": 2.0, "": 0.5}
"""Damping [N m s/rad] by prefix of the name."""
SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")
"""Leg joints with coupled passive moments."""
_DEG = 180.0 / np.pi


def scale(mass: float, height: float) -> float:
    """Return the ratio of a person's passive moments to the reference's."""
    return mass * height / (REFERENCE_MASS * REFERENCE_HEIGHT)


def linear_stiffness(names: Sequence[str]) -> list[float]:
    """Return the stiffness of each hinge about zero [N m/rad], of the reference mass and height.

    Joints of the trunk or the neck are in series: each of two is twice as stiff as the whole.

    Example:
        >>> linear_stiffness(["lumbar_bending"])
        [12.0]
        >>> linear_stiffness(["lumbar_bending", "thorax_bending", "arm_add_r"])
        [24.0, 24.0, 4.0]
    """
    found = []
    for name in names:
        stem, _ = split_side(name)
        joint, _, way = stem.rpartition("_")
        whole, joints = next(
            ((w, j) for w, j in IN_SERIES.items() if joint in j), (joint, (joint,))
        )
        series = sum(f"{each}_{way}" in names for each in joints) or 1
        found.append(series * STIFFNESS.get(f"{whole}_{way}", 0.0))
    return found


def passive_moments(names: Sequence[str], q: Any, qd: Any, factor: float = 1.0) -> list[Any]:
    """Return passive moments of hinges [N m], positive in the direction of their coordinate.

    Args:
        q: Angles, CasADi expressions or arrays [rad].
        qd: Rates of the angles [rad/s].
        factor: From :func:`scale`.

    Returns:
        One moment per hinge.
    """
    at = {n: i for i, n in enumerate(names)}
    exp = _exponential(q)
    moments: list[Any] = []
    for i, (name, stiffness) in enumerate(zip(names, linear_stiffness(names), strict=True)):
        stem, side = split_side(name)
        sagittal = [f"{s}_{side}" for s in SAGITTAL]
        if stem in SAGITTAL and all(s in at for s in sagittal):
            H, K, A = (q[at[s]] * _DEG for s in sagittal)
            terms, offset = _terms(H, K, A)[SAGITTAL.index(stem)]
            m = sum(sign * exp(power) for sign, _, power in terms) + offset
        else:
            m = -stiffness * q[i]
        damping = next(d for start, d in DAMPING.items() if stem.startswith(start))
        moments.append(factor * (m - damping * qd[i]))
    return moments


def sagittal_springs(
    angles: Float[Array, "3 n_legs"], factor: float = 1.0
) -> tuple[Float[Array, "3 n_legs"], Float[Array, "3 n_legs"]]:
    """Return static passive moments of hips, knees and ankles, and their stiffness.

    Args:
        angles: Angles, one row for each of :data:`SAGITTAL` [rad].
        factor: From :func:`scale`.

    Returns:
        Moments [N m], and their decrease with the joint's own angle, never negative [N m/rad].
    """
    values = np.exp(_POWERS @ (angles * _DEG) + _POWERS_AT_ZERO)
    moments = _SIGNS @ values + _OFFSETS
    return factor * moments, -_DEG * factor * (_SLOPES @ values)


def _terms(H: Any, K: Any, A: Any) -> tuple[tuple[tuple, float], ...]:
    """Return the exponentials and offsets of hip, knee and ankle.

    Each exponential has a sign, the exponent's derivative by the joint's own angle, and the
    exponent; angles in degrees.
    """
    hip = (
        (1.0, -0.0750, 1.4655 - 0.0034 * K - 0.0750 * H),
        (-1.0, 0.0305, 1.3403 - 0.0226 * K + 0.0305 * H),
    )
    knee = (
        (1.0, -0.0352, 1.800 + 0.0460 * A - 0.0352 * K + 0.0217 * H),
        (-1.0, 0.0495, -3.971 + 0.0004 * A + 0.0495 * K - 0.0128 * H),
        (1.0, -0.150, 2.220 - 0.150 * K),
    )
    ankle = (
        (1.0, -0.1949, -7.9763 - 0.1949 * A + 0.0008 * K),
        (-1.0, 0.0843, 2.1016 + 0.0843 * A - 0.0176 * K),
    )
    return (hip, 8.072), (knee, -4.820), (ankle, 1.792)


def _as_matrices() -> tuple[Array, Array, Array, Array, Array]:
    """Return exponents by angle and at zero, and the matrices of moments, slopes and offsets."""
    at_zero, *at_one = (_terms(*x) for x in np.vstack([np.zeros(3), np.eye(3)]))
    joint = np.repeat(np.arange(3), [len(terms) for terms, _ in at_zero])
    flat = [term for terms, _ in at_zero for term in terms]
    zero = np.array([power for *_, power in flat])
    one = [[power for terms, _ in found for *_, power in terms] for found in at_one]
    own = (joint == np.arange(3)[:, None]) * np.array([sign for sign, *_ in flat])
    slopes = own * np.array([slope for _, slope, _ in flat])
    offsets = np.array([offset for _, offset in at_zero])
    return np.array(one).T - zero[:, None], zero[:, None], own, slopes, offsets[:, None]


_POWERS, _POWERS_AT_ZERO, _SIGNS, _SLOPES, _OFFSETS = _as_matrices()


def _exponential(q: Any):
    """Return NumPy's or CasADi's exponential according to the type of ``q``."""
    if isinstance(q, np.ndarray | list | tuple):
        return np.exp
    import casadi

    return casadi.exp
