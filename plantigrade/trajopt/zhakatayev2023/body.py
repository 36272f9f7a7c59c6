"""The paper's body in our coordinates: which is which, where it starts, and what touches the floor.

The paper's model has 43 coordinates and 20 links, whose lengths and masses it does not print. Ours
is joint set ``43`` with feet of two segments and 77.5 kg: again 43 coordinates and 20 bodies. It is
1.80 m tall, since then the thigh is the 0.44 m by which the paper's pelvis sinks when sitting.
The description of its coordinates (section VI) translates as

=====================  ==============================  =====================================
paper                  what                            ours
=====================  ==============================  =====================================
:math:`q_1`            pelvis up                       ``pelvis_ty``
:math:`q_2`            pelvis forward (:math:`y_0`)    ``pelvis_tx``
:math:`q_3`            pelvis to the right             ``pelvis_tz``
:math:`q_9, q_{17}`    hips, flexion is negative       ``hip_flexion_r``, ``_l``, positive
:math:`q_{10},q_{18}`  knees, flexion is positive      ``knee_angle_r``, ``_l``, positive
:math:`q_{28},q_{37}`  elbows, flexion is negative     ``elbow_flex_r``, ``_l``, positive
=====================  ==============================  =====================================

and every angle is counted from the neutral pose, which is standing with the palms to the thighs.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import Point, contact_sites
from plantigrade.dynamics.symbolic import SymbolicHuman
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt.problem.constraint_family import node_symbols

Pose = Float[Array, " nv"]  # [rad, m] coordinates

MASS = 77.5  # [kg]
HEIGHT = 1.80  # [m]
CONTACTS = (
    "heel_back_medial",
    "heel_back_lateral",
    "metatarsal_1",
    "metatarsal_5",
    "toe_1",
    "toe_5",
)
"""The paper's contact points 1 to 6 of a foot: heel, ball (both on the hindfoot), toes."""


def paper_human() -> Human:
    """Return a person like the paper's: 43 coordinates, 20 links, 77.5 kg."""
    return Human.create(HEIGHT, MASS, joints="43", feet="two-segment")


@dataclass(frozen=True, eq=False)
class PaperBody:
    """A person with the names the paper's conditions need.

    Raises:
        ParameterError: If the feet do not have the six points.
    """

    human: Human  # the person; feet of two segments
    symbolic: SymbolicHuman  # its equations of motion

    @classmethod
    def of(cls, human: Human) -> "PaperBody":
        """Return the body of a person."""
        if human.feet != "two-segment":
            raise ParameterError(
                f"the paper's foot has a hindfoot and toes: two-segment, not {human.feet}"
            )
        return cls(human, SymbolicHuman(human))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return self.symbolic.names

    def index(self, name: str) -> int:
        """Return which coordinate has a name."""
        return self.names.index(name)

    @cached_property
    def neutral(self) -> Pose:
        """The neutral pose: standing at the origin [rad, m]."""
        return self.human.to_coordinates(self.human.standing()[None])[1][0]

    @cached_property
    def contacts(self) -> tuple[Point, ...]:
        """The six contact points of the right foot, then of the left."""
        names = [name for name, _, _ in self.human.contact_points]
        spheres = list(zip(names, contact_sites(self.human), strict=True))
        return tuple(
            next(p for n, p in spheres if n.endswith(f"_{name}")) for name in self.contact_names
        )

    @cached_property
    def contact_names(self) -> tuple[str, ...]:
        """Names of :attr:`contacts`."""
        return tuple(f"{name}_{side}" for side in SIDES for name in CONTACTS)

    @cached_property
    def resting(self) -> Float[Array, "12 3"]:
        """Where the contact points are in the neutral pose, world [m]."""
        positions = self.symbolic.positions(self.contacts)
        return np.array(positions(self.neutral)).T

    @cached_property
    def inputs(self) -> tuple[Any, ...]:
        """Symbols q, qd, qdd, u, p of the functions of a node; there are no u and no p."""
        return node_symbols(len(self.names))

    @property
    def weight(self) -> float:
        """Body weight [N]."""
        return self.symbolic.mass * float(np.linalg.norm(self.symbolic.gravity))

    def pose(self, **values: float) -> Pose:
        """Return the neutral pose with some coordinates set, both sides where none is named."""
        q = self.neutral.copy()
        for name, value in values.items():
            both = [name] if name in self.names else [f"{name}_{side}" for side in SIDES]
            for each in both:
                q[self.index(each)] = value
        return q

    def seated(self) -> Pose:
        """Return the pose of sitting with hips, knees and elbows at 90°, the feet as in standing.

        The paper sets the pelvis back and down by a thigh. Axes of knees and ankles are oblique in
        our model, so hips and ankles differ from 90° and zero by what keeps the soles flat.
        """
        import casadi as ca

        right = np.pi / 2
        q = self.pose(hip_flexion=right, knee_angle=right, elbow_flex=right)
        thigh = self.human.dimensions.thigh
        q[self.index("pelvis_tx")] -= thigh
        q[self.index("pelvis_ty")] -= thigh
        desired = q.copy()
        leg = ("hip_flexion", "hip_adduction", "hip_rotation", "ankle_angle", "subtalar_angle")
        free = [self.index(f"{n}_{s}") for n in (*leg, "mtp_angle") for s in SIDES]
        free += [self.index("pelvis_tx"), self.index("pelvis_ty")]
        symbol = ca.SX.sym("q", len(q))
        position = ca.vec(self.symbolic.positions(self.contacts)(symbol))
        jacobian = ca.Function("J", [symbol], [position, ca.jacobian(position, symbol)])
        for _ in range(30):
            position, J = (np.array(each) for each in jacobian(q))
            J, off = J[:, free], self.resting.ravel() - position[:, 0]
            inverse = np.linalg.pinv(J, rcond=1e-6)
            step = inverse @ off
            back = desired[free] - q[free]
            q[free] += step + back - inverse @ (J @ back)
            if np.abs(off).max() < 1e-12 and np.abs(step).max() < 1e-12:
                break
        return q
