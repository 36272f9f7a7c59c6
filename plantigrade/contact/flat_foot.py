"""Positions of the contact sites of a flat foot, for soles that are not flat at zero angles.

The standard feet are flat with all angles zero. The soles of a recorded person are fitted
(:mod:`plantigrade.kinematics.fitted_soles`): markers define the bone axes, in which a flat foot may
be pitched and tilted by some degrees.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import ContactSite
from plantigrade.models import Human

LEVEL_TOLERANCE = 1e-6  # [m] height range of a flat foot that needs no tilt
ANGLE_WEIGHT = 1e-4  # [m/rad] weight of angles against heights; small, to make the solution unique


def flat_sites(
    human: Human, sites: tuple[ContactSite, ...], side: str
) -> dict[str, Float[Array, " 3"]]:
    """Return the site positions of a flat foot relative to the ground below its ankle.

    Args:
        sites: Sites that can carry force; those of the other foot are ignored.

    Returns:
        Name → x along the foot, y to the left, both without the rolling of the sphere
        (:func:`~plantigrade.trajopt.problem.contact.site_places`), and the height of the
        lowest point [m].
    """
    own = [s for s in sites if s.side == side]
    foot = _Foot(human, own, side)
    x = np.zeros(2 + len(foot.hinges))
    height = foot.places(x)[:, 2]
    if len(own) > 2 and np.ptp(height) > LEVEL_TOLERANCE:
        from scipy.optimize import least_squares

        def height_error(x):
            height = foot.places(x)[:, 2]
            return np.concatenate([height - height.mean(), ANGLE_WEIGHT * x])

        x = least_squares(height_error, x, xtol=1e-12, ftol=1e-12, gtol=1e-14).x
        height = foot.places(x)[:, 2]
    places = foot.places(x)
    places[:, 2] -= height.mean()
    return {s.name: p for s, p in zip(own, places, strict=True)}


class _Foot:
    """A foot parametrised by its tilt and its internal angles."""

    def __init__(self, human: Human, sites: list[ContactSite], side: str):
        import mujoco

        self.human, self.model, self.sites = human, human.model, sites
        self.data = mujoco.MjData(self.model)
        self.foot = human.body(f"foot_{side}")
        self.at = [human.body(s.body) for s in sites]
        parent, inside = self.model.body_parentid, {self.foot}
        for b in range(self.foot + 1, self.model.nbody):
            if parent[b] in inside:
                inside.add(b)
        joints = [j for j in range(1, self.model.njnt) if self.model.jnt_bodyid[j] in inside]
        self.hinges = [
            int(self.model.jnt_qposadr[j]) for j in joints if self.model.jnt_bodyid[j] != self.foot
        ]

    def places(self, x: Float[Array, " n"]) -> Float[Array, "n_sites 3"]:
        """Return site positions for roll, pitch and internal angles, relative to the ankle [m]."""
        import mujoco

        self.data.qpos[:] = self.human.standing()
        self.data.qpos[7:] = 0.0
        self.data.qpos[self.hinges] = x[2:]
        mujoco.mj_kinematics(self.model, self.data)
        R = self.data.xmat[self.foot].reshape(3, 3)
        tilt = _turned(x[0], x[1]) @ R.T
        out = []
        for site, b in zip(self.sites, self.at, strict=True):
            turn = tilt @ self.data.xmat[b].reshape(3, 3)
            centre = tilt @ (self.data.xpos[b] - self.data.xpos[self.foot])
            centre = centre + turn @ np.array(site.position)
            rho = site.radius
            pitch, roll = np.arcsin(turn[2, 0]), np.arctan2(turn[2, 1], turn[2, 2])
            out.append(centre + rho * np.array([pitch, roll, -1.0]))
        return np.array(out)


def _turned(roll: float, pitch: float) -> Float[Array, "3 3"]:
    """Return the rotation by a pitch about y (negative: toes up), then a roll about x."""
    c, s = np.cos(pitch), np.sin(pitch)
    about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    c, s = np.cos(roll), np.sin(roll)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return about_x @ about_y
