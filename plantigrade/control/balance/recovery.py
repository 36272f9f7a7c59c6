"""Steps in a world: when one begins and ends, and what the tick of balance does meanwhile."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.balance.ground_contact import GroundContact, Standing, heights
from plantigrade.control.balance.step import EARLY, OUTSIDE, Pendulum, Swing, plan_step
from plantigrade.control.balance.support import beyond, inside
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.wbc.whole_body import Rows
from plantigrade.world import State

RESTS = 0.04
"""So long after a foot has come down, at least, another is lifted [s]."""
FOOT, TURN, STANDS, PELVIS = 500.0, 10.0, 10.0, 20.0
"""Weights of place and turn of a foot in the air, of the turn of one that stands, and of the
pelvis, which is kept upright."""
SLOWED = 20.0
"""How fast a foot that is about to stand comes to rest over the ground [1/s]."""
FELT = 3
"""Ticks in which a push is felt; their median counts, for a step on the ground is felt, too."""
GOES_ON = 1.0
"""Part of a push that is taken to go on until the foot comes down."""
NOISE, MOST = 0.7, 4.0
"""An acceleration up to the first is none, and beyond the second no push [m/s²]."""
HANGS = 0.02
"""Spheres no higher than this count as support [m]."""
CARRIES = 0.1
"""A foot that carries less cannot stand alone [body weights]."""
EDGE = 0.8
"""How far towards the edge of the standing foot the pressure goes, as a part."""
BENT = 0.03
"""How much lower the body is while it steps, of the length of a leg."""
LEG = ("hip", "knee", "ankle", "subtalar")
"""Joints that are where the steps have led them, not where the reference has them."""


class Recovery:
    """Takes steps when standing in place can no longer succeed.

    Args:
        human: The person.
        contact: The spheres of the feet.

    Attributes:
        swing: The foot in the air; None where both stand.
        stepped: Whether the feet are elsewhere than at the start.
        steps: How many steps were taken.
    """

    def __init__(self, human: Human, contact: GroundContact):
        self.human, self.contact = human, contact
        self.swing: Swing | None = None
        self.stepped, self.steps, self._landed = False, 0, -np.inf
        self._felt = np.zeros((FELT, 2))
        sides = [site.side for site in contact.world.sites if site.side]
        self.own = np.array([[side == s for side in sides] for s in SIDES])
        self.feet = [human.body(f"foot_{side}") for side in SIDES]
        owners = [human.body_names[i - 1] for i in contact.body]
        local = np.array(contact.model.geom_pos)[contact.geoms]
        self._points = PointSet(human, owners, local)
        stands = BodyState(human, human.standing())
        self._sole = np.array(
            [
                stands.rotation(f).T @ (self.spheres(stands)[own].mean(axis=0) - stands.origin(f))
                for f, own in zip(self.feet, self.own, strict=True)
            ]
        )
        hip, ankle = stands.origin(human.body("femur_r")), stands.origin(self.feet[0])
        self.leg = float(np.linalg.norm(hip - ankle))
        self._apart = float(np.linalg.norm(np.diff(self.soles(stands)[:, :2], axis=0)))
        self.legs = np.array([name.startswith(LEG) for name in human.coordinates])

    def spheres(self, body: BodyState) -> Float[Array, "n_sites 3"]:
        """Return where the spheres of the feet are [m]."""
        return body.position(self._points)

    def soles(self, body: BodyState) -> Float[Array, "2 3"]:
        """Return where the middles of the soles are [m]."""
        turn, origin = body.rotations[self.feet], body.origins[self.feet]
        return origin + np.einsum("kij,kj->ki", turn, self._sole)

    def feel(self, acceleration: Float[Array, " 3"]) -> None:
        """Take by how much the centre of mass was accelerated more than planned [m/s²]."""
        self._felt = np.vstack([self._felt[1:], acceleration[:2]])

    def _pushed(self) -> Float[Array, " 2"]:
        """Return what pushes besides the ground [m/s²], where it is no noise of a landing."""
        felt = np.median(self._felt, axis=0)
        size = float(np.linalg.norm(felt))
        return felt * min(max(size - NOISE, 0.0), MOST) / size if size else felt

    def look(self, state: State, standing: Standing) -> Standing:
        """Begin, go on with or end a step; return what carries: nothing of a foot in the air."""
        body = state.body
        places = self.spheres(body)
        now = self.pendulum(body, places, standing)
        touches = np.array([(standing.gap[own[standing.site]] <= 0).any() for own in self.own])
        if self.swing is not None:
            side, part = self.swing.step.side, self.swing.part(state.time)
            if part > EARLY and touches[side]:
                self.swing, self._landed = None, state.time
            else:
                self.swing = self.swing.replanned(now, state.time)
        elif touches.any() and state.time - self._landed > RESTS:
            # A foot that is lifted a little in leaning to the other can still be stood upon.
            carries = touches @ self.own | (heights(state, self.contact)[0] < HANGS)
            if beyond(places[carries, :2], now.capture_point + now.shift) > OUTSIDE:
                self._lift(state, now, touches)
        if self.swing is None:
            return standing
        return standing.at(~self.own[self.swing.step.side][standing.site])

    def _lift(self, state: State, now: Pendulum, touches: Array) -> None:
        """Begin a step with a foot, if the other one carries."""
        load = np.array([state.contact_force[: own.size][own, 2].sum() for own in self.own])
        able = touches & (load > CARRIES * state.body.mass * GRAVITY)
        if not able.any():
            return
        sides = [side for side in (0, 1) if able[1 - side]]
        self.swing = Swing(plan_step(now, sides), state.time)
        self.stepped, self.steps = True, self.steps + 1

    def pendulum(self, body: BodyState, places: Array, standing: Standing) -> Pendulum:
        """Return the person as a pendulum."""
        com, velocity, soles = body.com, body.com_velocity, self.soles(body)
        low = float(np.mean(standing.touching.place[:, 2])) if len(standing.site) else 0.0
        omega = np.sqrt(GRAVITY / max(com[2] - low, 0.3))
        point = com[:2] + velocity[:2] / omega
        pressure = np.array([inside(places[own, :2], point) for own in self.own])
        ahead = body.rotation(1)[:2, 0]
        return Pendulum(
            com[:2],
            velocity[:2],
            max(float(com[2] - low), 0.3),
            soles[:, :2],
            pressure,
            ahead / np.linalg.norm(ahead),
            self.leg,
            GOES_ON * self._pushed(),
        )

    def lowered(self, body: BodyState) -> float:
        """Return how much lower the centre of mass must be for the legs to reach the feet."""
        off = (self.soles(body) - body.com) @ body.rotation(1)
        aside = np.maximum(np.abs(off[:, 1]) - 0.5 * self._apart, 0.0)
        reach = min(float(np.hypot(off[:, 0], aside).max()), 0.7 * self.leg)
        return float(self.leg - np.sqrt(self.leg**2 - reach**2) + BENT * self.leg)

    def centre(self, body: BodyState, standing: Standing) -> Float[Array, " 2"]:
        """Return the acceleration of the centre of mass while a foot is in the air [m/s²].

        Pressure is as near to the capture point as the standing foot allows.
        """
        assert self.swing is not None
        now = self.pendulum(body, self.spheres(body), standing)
        side = 1 - self.swing.step.side
        pressure = EDGE * now.pressure[side] + (1 - EDGE) * now.feet[side]
        return now.omega**2 * (now.com - pressure)

    def rows(self, state: State) -> list[Rows]:
        """Return what the foot in the air is to do."""
        body = state.body
        if self.swing is None:
            return [rows for k in (0, 1) for rows in self._stands(state, k)]
        side = self.swing.step.side
        foot, place = self.feet[side], self.soles(body)[side]
        J, velocity, bias = body.touched(np.array([foot]), place[None])
        target = np.array([*self.swing.step.place, place[2]])
        ground = state.world.ground
        level = float((ground.under(target) - target[:2] @ ground.normal[:2]) / ground.normal[2])
        level += float(self.contact.model.geom_size[self.contact.geoms[0], 0])
        asked = self.swing.asked(state.time, place, velocity[0], level, self.leg)
        turn = self._level(state, side, TURN)
        return [Rows(J[0], asked - bias[0], FOOT), turn, *self._stands(state, 1 - side)]

    def _stands(self, state: State, side: int) -> list[Rows]:
        """Return the rows of a foot that stands, or is about to: flat, and where it is."""
        foot, place = self.feet[side], self.soles(state.body)[side]
        J, velocity, bias = state.body.touched(np.array([foot]), place[None])
        still = -SLOWED * velocity[0, :2] - bias[0, :2]
        return [self._level(state, side, STANDS), Rows(J[0, :2], still, FOOT)]

    def _level(self, state: State, side: int, weight: float) -> Rows:
        """Return the rows that lay a foot along the ground; one in the air faces forward, too."""
        body, foot, ground = state.body, self.feet[side], state.world.ground
        turn, spin = body.rotation(foot), body.angular_jacobian(foot)
        normal = ground.normal_at(body.origin(foot))
        flies = self.swing is not None and self.swing.step.side == side
        ahead = body.rotation(1)[:, 0] if flies else turn[:, 0]
        ahead = ahead - (ahead @ normal) * normal
        ahead /= np.linalg.norm(ahead)
        wanted = np.stack([ahead, np.cross(normal, ahead), normal], axis=1)
        off = 0.5 * np.cross(turn, wanted, axis=0).sum(axis=1)
        return Rows(spin, 200.0 * off - 28.0 * (spin @ body.qvel), weight)
