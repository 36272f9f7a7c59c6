"""Where the centre of mass is to be: over the points that press."""

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.control.balance.ground_contact import GroundContact
from plantigrade.control.balance.reference import Wanted
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human

INSIDE = 0.015
"""The centre of mass is to be no nearer to the edge of the support [m], where it is wide."""
TANGENTS = 48
"""Directions in which the edge of the support is looked at."""
_ANGLE = 2 * np.pi * np.arange(TANGENTS) / TANGENTS
_OUTWARD = np.stack([np.cos(_ANGLE), np.sin(_ANGLE)])


class Support:
    """The base of support of a reference, and where it has gone.

    Args:
        human: The person.
        contact: The spheres of the feet.
    """

    def __init__(self, human: Human, contact: GroundContact):
        self.human, self.contact = human, contact
        local = np.array(contact.model.geom_pos)[contact.geoms]
        self._local, self._body = local, contact.body
        self._reference: tuple[Wanted, Array, Array, Array] | None = None
        self._state: BodyState | None = None

    def goal(
        self, body: BodyState, wanted: Wanted, touches: Int[Array, " k"]
    ) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return where the centre of mass is to be, and how fast [m, m/s].

        That of the reference, moved with the points that press, and inside what they span; as far
        above those that touch as in the reference.

        Args:
            body: The person.
            wanted: The reference.
            touches: Which spheres touch.
        """
        com, speed, ref = self._wanted(wanted)
        now = self._places(body)
        mine = np.arange(len(now)) if wanted.presses is None else np.flatnonzero(wanted.presses)
        if not len(mine):
            return com, speed
        goal = com + (now - ref)[mine].mean(axis=0)
        goal[:2] = inside(now[mine, :2], goal[:2])
        on = np.intersect1d(mine, touches)
        goal[2] = com[2] + ((now - ref)[on, 2].mean() if len(on) else 0.0)
        return goal, speed

    def _wanted(self, wanted: Wanted) -> tuple[Array, Array, Array]:
        if self._reference is None or self._reference[0] is not wanted:
            state = (
                BodyState(self.human, wanted.qpos, wanted.qvel)
                if self._state is None
                else (self._state.moved_to(wanted.qpos, wanted.qvel))
            )
            self._state = state
            self._reference = wanted, state.com, state.com_velocity, self._places(state)
        return self._reference[1:]

    def _places(self, body: BodyState) -> Array:
        """Return where the spheres are."""
        turn, origin = body.rotations[self._body], body.origins[self._body]
        return origin + np.einsum("kij,kj->ki", turn, self._local)


def inside(points: Float[Array, "k 2"], place: Float[Array, " 2"]) -> Float[Array, " 2"]:
    """Return a place, or the first within what points span on the way from it to their middle.

    What they span is drawn in by :data:`INSIDE`, or by half of the way to the middle where that is
    less; its edge is that of its tangents in :data:`TANGENTS` directions.
    """
    middle = points.mean(axis=0)
    far = ((points - middle) @ _OUTWARD).max(axis=0)
    far -= np.minimum(INSIDE, 0.5 * far)
    off = (place - middle) @ _OUTWARD
    over = off > far
    if not over.any():
        return place
    return middle + (place - middle) * float((far[over] / off[over]).min())


def beyond(points: Float[Array, "k 2"], place: Float[Array, " 2"]) -> float:
    """Return how far a place is outside of what points span [m]; negative inside."""
    if not len(points):
        return np.inf
    return float((place @ _OUTWARD - (points @ _OUTWARD).max(axis=0)).max())
