r"""Detection of the reference point of torques in force files.

A file gives a force :math:`f`, its point of application :math:`p` and a torque :math:`t`, which
should be about :math:`p`. Some programs write it about the origin of the laboratory, or about a
fixed point of the plate, :math:`r`; some write what acts on the plate, with the other sign
:math:`s`. If :math:`p` is the centre of pressure, the horizontal part then follows the point,

.. math:: t_h \approx s\,[(p - r) \times f]_h ,

and so does the vertical part, apart from the free moment, which is small. Torques about the centre
of pressure do not follow it, nor do torques about a point that does not move. Read as torques about
:math:`p`, they would put the centre of pressure at twice its distance from :math:`r`.
"""

from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Bool, Float

MAX_MISFIT = 0.02
"""Largest distance of the centres of pressure by force and torque from those of the file, root mean
square [m]: filters at different frequencies leave up to 1 cm."""
MIN_LEVER_ARM = 0.1
"""Smallest lever arm of a torque about the origin, root mean square [m]: torques about a point of
the plate have smaller ones."""
MIN_PRESSURE_TRAVEL = 0.03
"""Smallest travel of the point of application, root mean square about its mean, for which a fixed
point other than the origin is determined [m]; along a foot in walking it is 0.06 to 0.09."""
MIN_VERTICAL_ARM = 0.02
"""Smallest vertical torque about the origin over the vertical force, root mean square [m]: free
moments of people who walk or run are below 0.01."""
MAX_FREE_SHARE = 0.35
"""Largest share of free moment in a vertical torque about the origin, root mean square."""


@dataclass(frozen=True)
class MomentReference:
    """Reference point of the torques of a file."""

    sign: float  #: 1 for torques on the body, -1 for those on the plate
    point: Float[Array, " 3"]  #: Fixed reference point, in the file's axes [m]
    #: 1 for each component in the file, 0 for those that are zero in it
    parts: Float[Array, " 3"] = field(default_factory=lambda: np.ones(3))

    def about(
        self, f: Float[Array, "*n 3"], p: Float[Array, "*n 3"], t: Float[Array, "*n 3"]
    ) -> Float[Array, "*n 3"]:
        """Return the torques on the body about the points ``p`` [N m]."""
        return np.where(np.isfinite(p), self.sign * t - self.parts * np.cross(p - self.point, f), t)

    def __str__(self) -> str:
        what = "the laboratory's origin"
        if self.point.any():
            what = "a fixed point at " + ", ".join(f"{x:.2f}" for x in self.point) + " m"
        sign = ", and of the body on the plate" if self.sign < 0 else ""
        return f"{what}{sign}"


def reference(
    f: Float[Array, "n 3"],
    p: Float[Array, "n 3"],
    t: Float[Array, "n 3"],
    loaded: Bool[Array, " n"],
    up: int,
    *,
    fixed: bool = True,
) -> MomentReference | None:
    """Return the fixed reference point of torques; None if it is ``p``.

    Args:
        f: Forces on the body [N].
        p: Points of application [m].
        t: Torques [N m].
        loaded: Samples with load on the plate.
        up: Index of the vertical axis.
        fixed: Whether fixed points other than the origin are considered.
    """
    loaded = loaded & np.isfinite(np.hstack([f, p, t])).all(axis=1)
    if loaded.sum() < 10:
        return None
    f, p, t = f[loaded], p[loaded], t[loaded]
    level = [axis for axis in range(3) if axis != up]
    weight = _rms(f[:, up])
    moment = np.cross(p, f)
    arm = _rms(t[:, level]) / weight
    if not t[:, level].any():
        vertical = t[:, up]
        if _rms(vertical) < MIN_VERTICAL_ARM * weight:
            return None
        for sign in (1.0, -1.0):
            if _rms(vertical - sign * moment[:, up]) < MAX_FREE_SHARE * _rms(vertical):
                return MomentReference(sign, np.zeros(3), np.eye(3)[up])
        return None
    if arm < MIN_LEVER_ARM and not fixed:
        return None
    for sign in (1.0, -1.0):
        if (
            arm >= MIN_LEVER_ARM
            and _rms(t[:, level] - sign * moment[:, level]) < MAX_MISFIT * weight
        ):
            return MomentReference(sign, np.zeros(3))
    travel = _rms((p - p.mean(axis=0))[:, level])
    if not fixed or travel < MIN_PRESSURE_TRAVEL:
        return None
    # r x f is linear in r: cross(e_i, f) are the columns.
    columns = np.stack([np.cross(np.eye(3)[i], f)[:, level].ravel() for i in range(3)], axis=1)
    for sign in (1.0, -1.0):
        required = moment[:, level] - sign * t[:, level]
        at = np.linalg.lstsq(columns, required.ravel(), rcond=None)[0]
        left = _rms(required - (columns @ at).reshape(required.shape))
        if (
            left < min(MAX_MISFIT, 0.3 * travel) * weight
            and _rms(p[:, level] - at[level]) > MAX_MISFIT
        ):
            return MomentReference(sign, at)
    return None


def _rms(values: Array) -> float:
    """Return the root mean square over samples of the length of each."""
    return float(np.sqrt(np.mean(np.sum(np.reshape(values, (len(values), -1)) ** 2, axis=1))))
