r"""Actions of a policy: displacements from the reference, and gains of the foot joints.

An action :math:`a = [\theta_{disp}, \alpha_{pd}]` within ±1 sets the target posture
:math:`\theta_{des} = \theta_{ref} + s\,\theta_{disp}` of stable PD, and the gains of each joint of
the foot [Park2020]_, Eqs. 8 and 9:

.. math:: k_p = \beta\, e^{\ln B \cdot \alpha} \qquad k_d = \gamma\, e^{\ln \Gamma \cdot \alpha / 2}

With :math:`B = \beta = k_p = 400` and :math:`\Gamma = \gamma = k_d = 40`, as printed, the stiffness
ranges from 1 to 160000 N m/rad: more than any tissue, but stable PD remains stable.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.reference import ReferenceInstant
from plantigrade.models import Human
from plantigrade.world.world_model import FOOT_PREFIXES


@dataclass(frozen=True, kw_only=True)
class Gains:
    """Gains of stable PD, and the range of those of the feet.

    Attributes:
        stiffness: Stiffness of all joints [N m/rad].
        damping: Damping of all joints [N m s/rad].
        foot_stiffness: Stiffness of the joints within a foot, :math:`β` [N m/rad].
        foot_damping: Damping of the joints within a foot, :math:`γ` [N m s/rad].
        ankle_too: Whether ankles have the gains of the foot instead of those of the body.
        span: Factor :math:`B` of the stiffness at an action of 1.
        damping_span: :math:`Γ`; its square root is the factor of the damping at an action of 1.
    """

    stiffness: float = 400.0
    damping: float = 40.0
    foot_stiffness: float = 60.0
    foot_damping: float = 2.0
    ankle_too: bool = False
    span: float = 60.0**0.5
    damping_span: float = 60.0**0.5


PAPER_GAINS = Gains(
    foot_stiffness=400.0, foot_damping=40.0, ankle_too=True, span=400.0, damping_span=40.0
)
"""Gains as printed in [Park2020]_."""

LANDING_GAINS = Gains(damping=20.0)
"""Gains of a training with landing rewarded. With half the damping, of 20 to 50 N m s/rad tried,
side pushes that are withstood, double support and the likeness of the ankle moment grew
(docs/learning.md); forces peak no lower for it."""


class Action:
    """Entries of an action, and the command they define.

    Args:
        all_joints: Whether joints within the feet are displaced, too.
        variable: Whether gains of the feet, ankles included, are part of the action.
        reach: Displacement at an action of 1, :math:`s` [rad].
        feed_rates: Whether the target rates are those of the reference instead of zero.

    Attributes:
        displaced: Indices of the displaced hinges, one entry each.
        joints: Joints with variable gains, named by the bodies they move, one entry each.
    """

    def __init__(
        self,
        human: Human,
        gains: Gains,
        *,
        all_joints: bool,
        variable: bool,
        reach: float,
        feed_rates: bool,
    ):
        self.gains, self.reach, self.feed_rates = gains, reach, feed_rates
        body = np.array(human.model.jnt_bodyid[1:])
        names = human.body_names
        foot = np.array([names[b - 1].startswith(FOOT_PREFIXES) for b in body])
        ankle = np.array([names[b - 1].startswith("foot") for b in body])
        self.displaced = np.flatnonzero(~foot | ankle | all_joints)
        own = foot & (~ankle | gains.ankle_too)
        self._stiffness = np.where(own, gains.foot_stiffness, gains.stiffness)
        self._damping = np.where(own, gains.foot_damping, gains.damping)
        moving = sorted(set(body[foot].tolist())) if variable else []
        self.joints = tuple(names[b - 1] for b in moving)
        self._variable = np.flatnonzero(np.isin(body, moving))
        self._joint = np.searchsorted(moving, body[self._variable]) if moving else np.array([], int)
        self._n = len(self.displaced)

    def __len__(self) -> int:
        return self._n + len(self.joints)

    @property
    def fixed(self) -> tuple[Float[Array, " n_hinges"], Float[Array, " n_hinges"]]:
        """Stiffness [N m/rad] and damping [N m s/rad] of all hinges without variable gains."""
        return self._stiffness, self._damping

    def gains_of(
        self, action: Float[Array, "n k"]
    ) -> tuple[Float[Array, "n n_hinges"], Float[Array, "n n_hinges"]]:
        """Return stiffness [N m/rad] and damping [N m s/rad] of all hinges, one row per action."""
        shape = (len(action), len(self._stiffness))
        stiffness, damping = (np.tile(x, (shape[0], 1)) for x in self.fixed)
        if self.joints:
            alpha = action[:, self._n :]
            stiffness[:, self._variable] *= (self.gains.span**alpha)[:, self._joint]
            factor = self.gains.damping_span ** (0.5 * alpha)
            damping[:, self._variable] *= factor[:, self._joint]
        return stiffness, damping

    def stiffness_of_joints(self, action: Float[Array, "n k"]) -> Float[Array, "n n_joints"]:
        """Return the stiffness of :attr:`joints` [N m/rad], one row per action."""
        first = np.unique(self._joint, return_index=True)[1]
        return self.gains_of(action)[0][:, self._variable[first]]

    def targets(
        self, action: Float[Array, "n k"], reference: ReferenceInstant
    ) -> Float[Array, "n n_hinges"]:
        """Return the target postures at the end of the control step [rad]."""
        target = reference.qpos[:, 7:].copy()
        target[:, self.displaced] += self.reach * action[:, : self._n]
        return target
