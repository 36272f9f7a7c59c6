r"""Six segments of a gymnast with symmetric sides.

The report's planar model has a lower arm, an upper arm, head and trunk, thighs, shanks and feet.
Here they are the bodies of a :class:`~plantigrade.models.Human` with its lengths, masses and
inertia, and a vault is a motion of this Human. Ten hinges move, five on each side; the others are
fixed by constraint forces without work. With :math:`q = q_0 + S \theta` the equations of the whole
body reduce without loss to

.. math:: S^T M S\,\ddot\theta + S^T h = S^T (\tau + J^T f).

Both sides are mirror images, so only the right one is modelled, with the mass of both. The axes of
elbow, knee and ankle are slightly oblique, so limbs swing a few millimetres sideways symmetrically;
trunk and centre of mass stay in the plane.

References:
    [Cheng2009]_, [deLeva1996]_.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.links import Link, links_of
from plantigrade.dynamics.recursions import LinkTree
from plantigrade.dynamics.symbolic import SymbolicHuman
from plantigrade.models import Human
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import PELVIS

COORDINATES = ("arm_flex", "elbow_flex", "hip_flexion", "knee_angle", "ankle_angle")
"""Moving coordinates without side, from the hands to the feet."""
JOINT_NAMES = ("shoulder", "elbow", "hip", "knee", "ankle")
"""Names of the same joints."""
ROOT_COORDINATES = ("pelvis_tx", "pelvis_ty", "pelvis_tilt")
"""Moving coordinates of the pelvis: forward [m], up [m], tilt [rad]."""
FIXED_ANGLES = {"pro_sup": 3.0, "wrist_flex": -1.25, "fingers_flex": -0.6}
"""Angles of fixed joints [rad]: palms on the table, wrists extended; all others are zero."""
PALM_OFFSET = 0.02
"""Distance from the wrist along the forearm to the hand's contact point [m]. Estimate."""


@dataclass(frozen=True)
class Segments:
    """A gymnast as six segments.

    Args:
        human: The person, of joint set ``"42"`` with rigid feet.
        elbow: Fixed elbow flexion of the report's five-segment model [rad]; None for a moving
            elbow.
    """

    human: Human
    elbow: float | None = None

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices of the moving :data:`JOINT_NAMES`."""
        return tuple(i for i, n in enumerate(JOINT_NAMES) if self.elbow is None or n != "elbow")

    @property
    def count(self) -> int:
        """Number of segments."""
        return 1 + len(self.joints)

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """Indices of the moving coordinates in ``theta`` = root and joints."""
        return (0, 1, 2, *(3 + i for i in self.joints))

    @cached_property
    def _merged(self) -> tuple[tuple[Link, ...], dict[str, tuple[int, Array, Array]]]:
        """Links of trunk and right side, and the link, rotation and position of each body.

        A fixed hinge is a constant rotation; a body without a moving hinge is merged with its
        parent; the masses of limbs are doubled.
        """
        names, hinges = self.human.body_names, self.human.coordinates
        found: list[Link] = []
        home: dict[int, tuple[int, Array, Array]] = {}
        for b, link in enumerate(links_of(self.human.model)):
            if names[b].endswith("_l"):
                continue
            factor = 2.0 if names[b].endswith("_r") else 1.0
            mass, first = factor * link.mass, factor * link.first.reshape(3, 1)
            second = factor * link.second
            if b == 0:
                found.append(replace(link, first=first))
                home[0] = 0, np.eye(3), np.zeros((3, 1))
                continue
            at, turn, place = home[link.parent]
            place = place + turn @ link.offset.reshape(3, 1)
            before = turn if link.turn is None else turn @ link.turn
            after, moved = np.eye(3), ()
            for i, axis in link.hinges:
                stem = hinges[i - 6].removesuffix("_r")
                if stem in COORDINATES:
                    moved = (*moved, (6 + COORDINATES.index(stem), axis))
                else:
                    held = Rotation.from_rotvec(FIXED_ANGLES.get(stem, 0.0) * axis).as_matrix()
                    before, after = (before, after @ held) if moved else (before @ held, after)
            if moved:
                first, second = after @ first, after @ second @ after.T
                plain = None if np.allclose(before, np.eye(3), atol=1e-15) else before
                found.append(Link(at, place, plain, moved, mass, first, second))
                home[b] = len(found) - 1, after, np.zeros((3, 1))
                continue
            whole, far = found[at], before @ first
            mixed = far @ place.T
            found[at] = replace(
                whole,
                mass=whole.mass + mass,
                first=whole.first + far + mass * place,
                second=whole.second + before @ second @ before.T + mixed + mixed.T
                + mass * place @ place.T,
            )  # fmt: skip
            home[b] = at, before, place
        return tuple(found), {names[b]: where for b, where in home.items()}

    def tree(self) -> LinkTree:
        """Return the segments for recursions in the eleven coordinates of :meth:`spread`."""
        tree = LinkTree(self.human, np.array(self.human.model.opt.gravity))
        tree.links, tree.nv = self._merged[0], 6 + len(COORDINATES)
        return tree

    def spread(self, ca: Any, theta: Any, *, rates: bool = False) -> Any:
        """Return the tree's coordinates or rates, with OpenSim's pelvis, from the moving ones."""
        place = [3, 4, 0, *range(6, 6 + len(COORDINATES))]
        S = np.zeros((6 + len(COORDINATES), len(self.moving)))
        S[[place[i] for i in self.moving], range(len(self.moving))] = 1.0
        found = ca.mtimes(ca.sparsify(ca.DM(S)), theta)
        if self.elbow is not None and not rates:
            found[6 + JOINT_NAMES.index("elbow")] = self.elbow
        return found

    def hand(self, ca: Any, tree: LinkTree, q: Any) -> Any:
        """Return the contact point of the right hand, world frame (3,) [m]."""
        at, _, place = self._merged[1]["hand_r"]
        rotation, origin = tree.frames(ca, q, tree.turns(ca, q), [at])
        return origin[at] + ca.mtimes(rotation[at], ca.DM(place + [[0.0], [0.0], [-PALM_OFFSET]]))

    def sites(self) -> tuple[ContactSite, ...]:
        """Return the contact sites of both hands."""
        axis = self.human.model.joint("wrist_flex_r").axis
        back = Rotation.from_rotvec(-FIXED_ANGLES["wrist_flex"] * axis)
        place = back.apply([0.0, 0.0, -PALM_OFFSET])
        return tuple(
            ContactSite(
                body=f"hand_{side}",
                position=place * [1.0, 1.0 if side == "r" else -1.0, 1.0],
                name=f"palm_{side}",
                part="hand",
                measured=True,
            )
            for side in SIDES
        )

    def whole(
        self,
        theta: Float[Array, "n 8"],
        rate: Float[Array, "n 8"],
        acceleration: Float[Array, "n 8"],
    ) -> tuple[Float[Array, "n nq"], Float[Array, "n nv"], Float[Array, "n nv"]]:
        """Return configuration, velocity and acceleration of the symmetric Human.

        Args:
            theta: Pelvis forward and up [m], its tilt, then the joints in the order of
                :data:`COORDINATES` [rad].
            rate: Rates of ``theta``.
            acceleration: Second derivatives of ``theta``.
        """
        body = SymbolicHuman(self.human)
        S, zero = np.zeros((body.nv, 8)), np.zeros(body.nv)
        for i, name in enumerate(body.names):
            stem, _ = split_side(name)
            if name in PELVIS and name in ROOT_COORDINATES:
                S[i, ROOT_COORDINATES.index(name)] = 1.0
            elif stem in COORDINATES:
                S[i, 3 + COORDINATES.index(stem)] = 1.0
            else:
                zero[i] = FIXED_ANGLES.get(stem, 0.0)
        return body.to_mujoco(zero + theta @ S.T, rate @ S.T, acceleration @ S.T)
