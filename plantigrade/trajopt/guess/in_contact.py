r"""A first guess that rests where its plan says, by inverse kinematics of the whole body.

At every time the posture :math:`q` near a given one :math:`\bar q` is sought whose sites are at
their places,

.. math:: \min_q \sum_j w_j (q_j - \bar q_j)^2 + \frac{1}{\varepsilon} \lVert r(q) \rVert^2,

:math:`r` being how far the rows of contact are from what the plan holds them at. Of the
rows of a foot that have only a lower limit the deepest counts. It is done first at a few times,
between which the postures are interpolated, then at all.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import KNEE_PART
from plantigrade.contact.plan import ContactPlan
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD
from plantigrade.trajopt.guess.foot_motion import with_toes
from plantigrade.trajopt.problem.contact import headings, hold_contacts, site_places
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.transcription.derivatives import derivatives_of

PRECISION = (1e-5, 1e-9)
"""ε at first and in the second half of the iterations [m²/rad²]: a millimetre off weighs as much as
0.3 rad, then 30."""
FIXED = 1e12  # [1] weight of a joint that stays where it is
MARGIN = 0.03  # [rad] how far joints stay within their limits
MAX_STEP = 0.3  # [rad, m] largest change of a coordinate in an iteration
ITERATIONS = 40  # of the inverse kinematics; it converges in 10 to 25
LEG = ("hip", "knee", "ankle", "subtalar", "mtp")  # prefixes of coordinates of a leg
LEG_WEIGHT = 0.05  # [1] weight of hips, knees and feet, which adapt to the places
PLACE_WEIGHT = 0.01  # [1/m²] weight of the place of the pelvis ahead and up
ASIDE_WEIGHT = 1.0  # [1/m²] weight of its place to the side
KNEELING = {
    "knee_angle": 1.75, "hip_flexion": 0.0, "ankle_angle": 0.7, "mtp_angle": 1.1,
}  # fmt: skip
"""Angles of a leg that kneels on its toes, to start from [rad]."""


@dataclass(frozen=True)
class InContact:
    """A guess, changed so that everything rests where the plan has it.

    It is interpolated between its own postures, or those where contacts change and in the middle.
    """

    guess: Callable[[ContactBody, ContactPlan, Array], Array]

    def __call__(
        self, body: ContactBody, plan: ContactPlan, times: Float[Array, " n_times"]
    ) -> Float[Array, "n_times nv"]:
        """Return coordinates at times."""
        from scipy.interpolate import PchipInterpolator

        changes = plan.switches
        own = self.guess.times if isinstance(self.guess, Interpolated) else ()
        keys = np.array(own or np.sort([*changes, *(changes[1:] + changes[:-1]) / 2]))
        postures = kneeling(body, plan, keys, self.guess(body, plan, keys))
        smooth = PchipInterpolator(keys, resting(body, plan, keys, postures))
        return resting(body, plan, times, smooth(times))


@dataclass(frozen=True)
class Interpolated:
    """Postures at times, and smooth in between."""

    times: tuple[float, ...]  #: When the postures are taken [s]
    postures: tuple[Float[Array, " nv"], ...]  #: Coordinates [rad, m]

    def __call__(
        self, body: ContactBody, plan: ContactPlan, times: Float[Array, " n_times"]
    ) -> Float[Array, "n_times nv"]:
        """Return coordinates at times."""
        from scipy.interpolate import PchipInterpolator

        inside = np.clip(times, self.times[0], self.times[-1])
        return PchipInterpolator(self.times, np.array(self.postures))(inside)


def kneeling(
    body: ContactBody, plan: ContactPlan, times: Float[Array, " n"], q: Float[Array, "n nv"]
) -> Float[Array, "n nv"]:
    """Return postures with bent legs where they kneel, the hips above the mean of the knees."""
    q, human, names = q.copy(), body.human, body.symbolic.names
    for i, time in enumerate(times):
        held = [s for s in plan.supports if s.site.part == KNEE_PART and s.start <= time <= s.stop]
        if not held or max(q[i, names.index(f"knee_angle_{s.site.body[-1]}")] for s in held) > 1.0:
            continue  # none kneels, or the posture knows how
        for support in held:
            side = support.site.body[-1]
            for name, angle in with_toes(human, KNEELING).items():
                if f"{name}_{side}" in names:
                    q[i, names.index(f"{name}_{side}")] = angle
        x, y, z = np.mean([s.places(times[i : i + 1])[0] for s in held], axis=0)
        hip = human.model.body_pos[human.body("femur_r")]
        up = z + held[0].site.radius + human.dimensions.thigh - hip[2]
        q[i, 3:6] = (
            np.array([x - hip[0], q[i, 3:6] @ OPENSIM_TO_WORLD.T @ [0, 1, 0], up])
            @ OPENSIM_TO_WORLD
        )
    return q


def resting(
    body: ContactBody, plan: ContactPlan, times: Float[Array, " n"], q: Float[Array, "n nv"]
) -> Float[Array, "n nv"]:
    """Return the postures nearest to some whose sites are where the plan has them at times [s]."""
    n, nv, names = len(times), body.symbolic.nv, body.symbolic.names
    directions = headings(body, plan, times)
    place, speed = (site_places(body, directions, rates=rates) for rates in (False, True))
    hold_contacts(body, plan, times, place, speed)
    rows = derivatives_of(place.function)
    weight = np.ones(nv)
    weight[3:5], weight[5] = PLACE_WEIGHT, ASIDE_WEIGHT
    weight[[i for i, name in enumerate(names) if name.startswith(LEG)]] = LEG_WEIGHT
    low, high = np.full(nv, -np.inf), np.full(nv, np.inf)
    low[6:], high[6:] = body.human.limits + np.array([[MARGIN], [-MARGIN]])
    desired, q = q, np.clip(q, low, high)
    zero, u = np.zeros((n, nv)), np.zeros((n, 3 * len(body.sites)))
    held = place.equations.copy()
    for i in range(ITERATIONS):
        precision = PRECISION[2 * i // ITERATIONS]
        value, J = rows.jacobian(q, zero, zero, u, place.parameters)
        J = J[:, :, :nv]
        off = np.clip(value, place.lower, place.upper) - value
        held |= (off != 0.0) & _deepest(body, off)  # once broken, a limit is where the row stays
        off = np.where(held, np.clip(place.lower, None, place.upper) - value, 0.0)
        J = J * held[:, :, None]
        A = np.einsum("nri,nrj->nij", J, J) / precision + np.diag(weight)
        b = np.einsum("nri,nr->ni", J, off) / precision + weight * (desired - q)
        step = np.linalg.solve(A, b[..., None])[..., 0]
        stuck = ((q <= low) & (step < 0.0)) | ((q >= high) & (step > 0.0))
        A += stuck[:, None, :] * (FIXED * np.eye(nv))  # a joint at its limit stays there
        step = np.linalg.solve(A, np.where(stuck, 0.0, b)[..., None])[..., 0]
        largest = np.abs(step).max(axis=1, keepdims=True)
        q = np.clip(q + step * np.minimum(1.0, MAX_STEP / np.maximum(largest, 1e-12)), low, high)
    return q


def _deepest(body: ContactBody, off: Float[Array, "n n_rows"]) -> Bool[Array, "n n_rows"]:
    """Return which row of each foot is farthest off; to lift all would lay the foot flat."""
    out = np.ones(off.shape, bool)
    sides = np.repeat([site.side for site in body.sites], 3)
    for side in SIDES:
        own = sides == side
        out[:, own] = np.abs(off[:, own]) >= np.abs(off[:, own]).max(axis=1, keepdims=True)
    return out
