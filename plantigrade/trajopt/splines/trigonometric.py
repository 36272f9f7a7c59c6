"""Trigonometric splines."""

from collections.abc import Hashable
from math import comb

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.trajopt.splines.basis import Basis, Side


class TrigonometricBasis(Basis):
    r"""Trigonometric splines, the basis of [Zhakatayev2023]_ (Eqs. 5–8) and [LycheWinther1979]_.

    Time is scaled to an angle, :math:`\theta = \omega (t - t_\mathrm{start})`, and with
    :math:`\theta_l` the scaled knots

    .. math::
        N_{l,0} &= 1 \text{ for } \theta_l \le \theta < \theta_{l+1}, \text{ else } 0, \\
        N_{l,\gamma} &= \frac{\sin(\theta - \theta_l)}{\sin(\theta_{l+\gamma} - \theta_l)}
            N_{l,\gamma-1}
            + \frac{\sin(\theta_{l+\gamma+1} - \theta)}{\sin(\theta_{l+\gamma+1} - \theta_{l+1})}
            N_{l+1,\gamma-1}, \\
        \frac{dN_{l,\gamma}}{d\theta} &= \gamma \left(
            \frac{\cos(\theta - \theta_l)}{\sin(\theta_{l+\gamma} - \theta_l)} N_{l,\gamma-1}
            - \frac{\cos(\theta_{l+\gamma+1} - \theta)}{\sin(\theta_{l+\gamma+1} - \theta_{l+1})}
            N_{l+1,\gamma-1} \right).

    Higher derivatives differentiate the last line by the product rule, so that every order is
    analytic, jerk included; the second is Eq. 8. The :math:`d`-th by time is :math:`\omega^d`
    times that. Where knots coincide, :math:`0/0 = 0` (Eq. 6): only functions whose support holds
    the time are ever formed here, and for those no denominator vanishes.

    **Eqs. 7 and 8 as printed** are right: no sign, index or factor differs from automatic
    differentiation of Eq. 5, at degrees 2 to 5, on uneven knots with multiplicities. Left unsaid:

    - Both are derivatives by scaled time; factors :math:`\omega`, :math:`\omega^2` are to be added.
    - At degree 1 Eq. 8, and at degree 0 both, name functions of negative degree. Those terms have a
      factor zero and are to be dropped; their denominators need not vanish.
    - By Eq. 5 every function is zero at the last knot; the last piece has to be closed.
    - The limit :math:`t < \pi` is one on differences: every support has to be shorter than
      :math:`\pi`. At a difference of :math:`\pi` the sine in Eq. 6 vanishes too, though that is no
      0/0; it is refused here.

    These replace the partition of unity, for :math:`\gamma + 1` knots of a support less than
    :math:`\pi` apart:

    - Functions are positive inside their support and zero outside.
    - Pieces lie in the space of :math:`\cos k\theta` and :math:`\sin k\theta`,
      :math:`k = \gamma, \gamma - 2, \dots \ge 0`, and those are reproduced exactly
      (:meth:`harmonic`), since :math:`\sin^\gamma(y - \theta) = \sum_l N_{l,\gamma}
      \prod_{i=1}^{\gamma} \sin(y - \theta_{l+i})` for every :math:`y`.
    - Constants are among them for even degrees only, with the coefficients :meth:`unity`, none
      above one. For odd degrees no pose is held exactly. At degree 3 and 2 rad, clamped, the sum of
      the functions reaches 1.19 with 6 even pieces, 1.0067 with 30, 1.0017 with 60; with the
      coefficients :meth:`unity` it is one to 2.1e-4, 3.3e-7, 2.1e-8. Coefficients are therefore not
      poses and give no bounds on them.
    - As the angle goes to zero they become polynomial B-splines, with its square.

    Attributes:
        angle: Angle :math:`\omega (t_\mathrm{stop} - t_\mathrm{start})` that the span is
            scaled to [rad], below :math:`\pi`; of a periodic basis, only each support has to be.
    """

    def __init__(
        self,
        degree: int,
        knots: Float[Array, " n_knots"],
        *,
        angle: float = 2.0,
        periodic: bool = False,
    ):
        super().__init__(degree, knots, periodic=periodic)
        self.angle = float(angle)
        if not 0 < self.angle < np.inf or (self.angle >= np.pi and not periodic):
            raise ParameterError(
                f"{angle=} [rad] of the whole span must be above 0 and below pi: "
                "about 2 keeps clear of both"
            )
        widest = float(np.max(self.knots[self.degree + 1 :] - self.knots[: -self.degree - 1]))
        if not self.rate * widest < np.pi:
            raise ParameterError(
                f"a basis function of degree {degree} spans {self.rate * widest:.3g} rad, and pi "
                "is the limit: give more knots, a lower degree or an angle below "
                f"{np.pi * self.span / widest:.3g} rad"
            )

    @property
    def rate(self) -> float:
        r"""Scale :math:`\omega` of time [rad/s]."""
        return self.angle / self.span

    def evaluate(
        self, times: Float[Array, " n_times"], derivative: int, side: Side
    ) -> tuple[Float[Array, "n_times order"], Int[Array, " n_times"]]:
        """Return the non-zero functions and the first of them, see :meth:`Basis.evaluate`."""
        piece = self._piece(times, side)
        knots, theta = self._angles(), self.rate * (times - self.start)[:, None]
        # table[d] holds the d-th derivatives of the functions of the current degree
        table = [np.ones((len(times), 1))] + [np.zeros((len(times), 1))] * derivative
        for degree in range(1, self.degree + 1):
            left = piece[:, None] + np.arange(1 - degree, 1)  # l of the functions one degree lower
            since, until = theta - knots[left], knots[left + degree] - theta
            weight = 1 / np.sin(knots[left + degree] - knots[left])
            sin_since, cos_since, sin_until, cos_until = (
                f(x) * weight for x in (since, until) for f in (np.sin, np.cos)
            )
            # k-th derivatives of cos(since) and of -cos(until), k modulo 4
            rise = (cos_since, -sin_since, -cos_since, sin_since)
            fall = (-cos_until, -sin_until, cos_until, sin_until)
            raised = []
            for d in range(derivative + 1):
                if d == 0:
                    up, down = sin_since * table[0], sin_until * table[0]
                else:
                    terms = [(comb(d - 1, k), k % 4, table[d - 1 - k]) for k in range(d)]
                    up = degree * sum(c * rise[k] * lower for c, k, lower in terms)
                    down = degree * sum(c * fall[k] * lower for c, k, lower in terms)
                values = np.zeros((len(times), degree + 1))
                values[:, 1:] += up
                values[:, :-1] += down
                raised.append(values)
            table = raised
        return table[derivative] * self.rate**derivative, piece - self.degree

    def harmonic(
        self, k: int
    ) -> tuple[Float[Array, " n_coefficients"], Float[Array, " n_coefficients"]]:
        r"""Return the coefficients of :math:`\cos k\theta` and :math:`\sin k\theta`, both exact.

        Both sides of the identity for :math:`\sin^\gamma(y - \theta)` are compared power by power
        of :math:`e^{iy}`. Those of :math:`e^{ik\theta}` are means over all choices :math:`S` of
        :math:`(\gamma + k) / 2` knots out of :math:`\theta_{l+1} \dots \theta_{l+\gamma}`,

        .. math:: c_l = \operatorname{mean}_S \exp
            \Big(i \sum_{j \in S} \theta_j - i \sum_{j \notin S} \theta_j\Big).

        Args:
            k: Harmonic of the angle, one of :math:`\gamma, \gamma - 2, \dots \ge 0`.

        Returns:
            Coefficients of cosine and sine, :math:`\theta = 0` at ``start``.
        """
        if k not in range(self.degree % 2, self.degree + 1, 2):
            allowed = ", ".join(map(str, range(self.degree % 2, self.degree + 1, 2)))
            raise ParameterError(
                f"harmonic {k} is not in degree {self.degree}, which has {allowed}"
            )
        turns = k * self.angle / (2 * np.pi)
        if self.periodic and abs(turns - round(turns)) > 1e-9:
            raise ParameterError(f"harmonic {k} turns {turns:g} times in a period, which repeats")
        n, knots = self.n_coefficients, self._angles()
        chosen = np.zeros((n, self.degree + 1), dtype=complex)  # column: how many knots are in S
        chosen[:, 0] = 1
        for i in range(1, self.degree + 1):
            turn = np.exp(1j * knots[i : i + n])[:, None]
            chosen = chosen / turn + np.roll(chosen, 1, axis=1) * turn
        pick = (self.degree + k) // 2
        coefficients = chosen[:, pick] / comb(self.degree, pick)
        return coefficients.real, coefficients.imag

    def unity(self) -> Float[Array, " n_coefficients"]:
        """Return the coefficients of the constant 1: exact for even degrees, else the nearest."""
        return super().unity() if self.degree % 2 else self.harmonic(0)[0]

    def _identity(self) -> tuple[Hashable, ...]:
        return (*super()._identity(), self.angle)

    def _angles(self) -> Float[Array, " n_knots"]:
        return self.rate * (self.knots - self.start)

    def _piece(self, times: Float[Array, " n_times"], side: Side) -> Int[Array, " n_times"]:
        """Return the knot each time's piece begins at; at a knot, the piece on that side."""
        first = np.searchsorted(self.knots, self.start, "right") - 1
        last = np.searchsorted(self.knots, self.stop, "left") - 1
        return np.clip(np.searchsorted(self.knots, times, side) - 1, first, last)
