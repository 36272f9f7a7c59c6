"""Steps in a world: when one begins and ends, and what the tick of balance does meanwhile."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.balance.ground_contact import GroundContact, Standing, heights
from plantigrade.control.gait.step import EARLY, OUTSIDE, Pendulum, Swing, plan_step
from plantigrade.control.gait.support import beyond, inside, nearest
from plantigrade.kinematics.state import CROSS, PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.wbc.whole_body import Rows
from plantigrade.world import State

RESTS = 0.04
"""So long after a foot has come down, at least, another is lifted [s]."""
FOOT, TURN, STANDS, PELVIS = 500.0, 10.0, 10.0, 50.0
"""Weights of place and turn of a foot in the air, of the turn of one that stands, and of the
pelvis, which is kept upright."""
TRUNK, LEANS = 50.0, 8.0
"""Weight of the lean of the trunk, and how fast it is taken back [1/s]: hips and arms may help, but
who bows deeply has nothing left for the next step."""
SLOWED = 20.0
"""How fast a foot that is about to stand comes to rest over the ground [1/s]."""
STRIKES = 0.15
"""What is felt while the force of the ground changes by more is not believed [body weights]."""
AGAIN = 0.03
"""As :data:`OUTSIDE`, once there were steps [m]."""
FELT = 3
"""Ticks in which a push is felt; their median counts, for a step on the ground is felt, too."""
NOISE, MOST = 0.7, 5.0
"""An acceleration up to the first is none, from twice that on a push, and the second the greatest
that is believed [m/s²]."""
HANGS = 0.02
"""Spheres no higher than this count as support [m]."""
CARRIES = 0.1
"""A foot that carries less cannot stand alone [body weights]."""
EDGE = 0.8
"""How far towards the edge of the standing foot the pressure goes, as a part."""
CAPTURES, HELP = 1.0, 0.05
"""How much farther than the capture point the pressure goes, of its way to where it is to be, and
how far beyond the feet arms and trunk are to lead it [m]."""
SETTLES, QUIET = 0.3, 0.15
"""Who is slower than the second so long after a step [s, m/s] stands as they are."""
SINKS = 3.0
"""Greatest vertical acceleration asked for [m/s²]: who sinks fast has no weight on the feet, and
without it no friction that stops a fall."""
BENT = 0.06
"""How much lower the body is while it steps, of the length of a leg."""
BACK, SPINE = ("lumbar", "thorax", "neck"), 5.0
"""Joints of trunk and neck, and their weight: arms may swing, but a trunk that twists takes the
pelvis along when it can go no farther."""
SIDE_NAMES = ("right", "left")
"""What the sides are called, in the order of feet."""
TOLD = 0.03
"""Less than this is not told of a step [m]."""
LEG = ("hip", "knee", "ankle", "subtalar")
"""Joints that are where the steps have led them, not where the reference has them."""


class Recovery:
    """Takes steps when standing in place can no longer succeed.

    Args:
        human: The person.
        contact: The spheres of the feet.

    Attributes:
        swing: The foot in the air; None where both stand.
        steps: How many steps were begun.
        settled: Angles of the joints in which the person came to rest where the steps have led
            them, held from then on [rad]; None before.
        taken: Of each step when it began and ended [s], which foot, and how far it went forward
            and to the left [m].
    """

    def __init__(self, human: Human, contact: GroundContact):
        self.human, self.contact = human, contact
        self.swing: Swing | None = None
        self.steps, self._landed = 0, -np.inf
        self.settled: Array | None = None
        self.taken: list[tuple[float, float, int, float, float]] = []
        self._felt = np.zeros((FELT, 2))
        self._before: tuple[float, Array, Array] | None = None
        sides = [site.side for site in contact.world.sites if site.side]
        self.own = np.array([[side == s for side in sides] for s in SIDES])
        self.feet = [human.body(f"foot_{side}") for side in SIDES]
        owners = [human.body_names[i - 1] for i in contact.body]
        local = np.array(contact.model.geom_pos)[contact.geoms]
        self._points = PointSet(human, owners, local)
        stands = BodyState(human, human.standing())
        middles = [
            stands.rotation(f).T @ (self.spheres(stands)[own].mean(axis=0) - stands.origin(f))
            for f, own in zip(self.feet, self.own, strict=True)
        ]
        self._soles = PointSet(human, [f"foot_{side}" for side in SIDES], np.array(middles))
        self._up = stands.rotation(human.trunk).T @ np.array([0.0, 0.0, 1.0])
        hip, ankle = stands.origin(human.body("femur_r")), stands.origin(self.feet[0])
        self.leg = float(np.linalg.norm(hip - ankle))
        self._apart = float(np.linalg.norm(np.diff(self.soles(stands)[:, :2], axis=0)))
        self.spine = np.array([name.startswith(BACK) for name in human.coordinates])
        self.legs = np.array([name.startswith(LEG) for name in human.coordinates])

    @property
    def stepped(self) -> bool:
        """Whether a foot was lifted: they are elsewhere than at the start."""
        return self.steps > 0

    def said(self) -> tuple[str, ...]:
        """Return in words what steps were taken."""
        if not self.taken:
            return ()
        told = [
            f"{SIDE_NAMES[side]} foot at {begin:.2f} s, {_way(along, left)}, "
            f"in {1e3 * (end - begin):.0f} ms"
            for begin, end, side, along, left in self.taken
        ]
        count = "One recovery step" if len(told) == 1 else f"{len(told)} recovery steps"
        return (f"{count}: {'; '.join(told)}.",)

    def opposing(self, state: State) -> float:
        """Return the force with which the feet push against each other along the ground [N].

        Positive where they push apart, negative where they pull together; what one foot gives and
        the other takes moves nobody.
        """
        force = [state.contact_force[: own.size][own, :2].sum(axis=0) for own in self.own]
        between = np.diff(self.soles(state.body)[:, :2], axis=0)[0]
        between /= max(float(np.linalg.norm(between)), 1e-9)
        right, left = float(force[0] @ between), float(-force[1] @ between)
        return min(right, left) if min(right, left) > 0 else max(min(right, 0.0), min(left, 0.0))

    def spheres(self, body: BodyState) -> Float[Array, "n_sites 3"]:
        """Return where the spheres of the feet are [m]."""
        return body.position(self._points)

    def soles(self, body: BodyState) -> Float[Array, "2 3"]:
        """Return where the middles of the soles are [m]."""
        return body.position(self._soles)

    def feel(self, state: State) -> None:
        """Take in by how much the centre of mass was accelerated more than the ground explains."""
        velocity, force = state.body.com_velocity[:2], state.contact_force.sum(axis=0)[:2]
        if self._before is not None:
            time, before, pressed = self._before
            ground = 0.5 * (force + pressed) / state.body.mass
            felt = (velocity - before) / max(state.time - time, 1e-6) - ground
            change = float(np.linalg.norm(force - pressed))
            if change < STRIKES * state.body.mass * GRAVITY:  # a foot that strikes is no push
                self._felt = np.vstack([self._felt[1:], felt])
        self._before = state.time, velocity, force

    def _pushed(self) -> Float[Array, " 2"]:
        """Return what pushes besides the ground [m/s²], where it is no noise of a landing."""
        felt = np.median(self._felt, axis=0)
        size = float(np.linalg.norm(felt))
        if size <= NOISE:
            return 0.0 * felt
        return felt * min(size / NOISE - 1.0, 1.0, MOST / size)

    def look(self, state: State, standing: Standing) -> Standing:
        """Begin, go on with or end a step; return what carries: nothing of a foot in the air."""
        body = state.body
        places = self.spheres(body)
        now = self.pendulum(body, places, standing)
        touches = np.array([(standing.gap[own[standing.site]] <= 0).any() for own in self.own])
        if self.swing is not None:
            side, part = self.swing.step.side, self.swing.part(state.time)
            if part > EARLY and touches[side]:
                ahead, start = now.heading, self._start
                far = self.soles(body)[side, :2] - start
                along, left = float(far @ ahead), float(ahead[0] * far[1] - ahead[1] * far[0])
                self.taken.append((self.swing.begin, state.time, side, along, left))
                self.swing, self._landed = None, state.time
            else:
                velocity = body.velocity(self._soles)[side, :2]
                self.swing = self.swing.replanned(now, state.time, velocity)
        elif touches.any() and state.time - self._landed > RESTS:
            quiet = self.stepped and state.time - self._landed > SETTLES
            if self.settled is None and quiet and np.linalg.norm(body.com_velocity) < QUIET:
                self.settled = np.array(state.angles)
            # A foot that is lifted a little in leaning to the other can still be stood upon.
            carries = touches @ self.own | (heights(state, self.contact)[0] < HANGS)
            most = AGAIN if self.stepped else OUTSIDE
            if beyond(places[carries, :2], now.capture_point + now.shift) > most:
                self._lift(state, now, touches)
        if self.swing is None:
            return standing
        return standing.at(~self.own[self.swing.step.side][standing.site])

    def _level_at(self, state: State, place: Float[Array, " 3"]) -> float:
        """Return how high the middle of a sole is that stands there [m]."""
        ground = state.world.ground
        level = float((ground.under(place) - place[:2] @ ground.normal[:2]) / ground.normal[2])
        return level + float(self.contact.model.geom_size[self.contact.geoms[0], 0])

    def _lift(self, state: State, now: Pendulum, touches: Array) -> None:
        """Begin a step with the better of the feet beside which the other one touches."""
        sides = [side for side in (0, 1) if touches[1 - side]]
        self.swing = Swing(plan_step(now, sides), state.time)
        self.settled = None
        self._start = now.feet[self.swing.step.side]
        self.steps += 1

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
            self._pushed(),
        )

    def lowered(self, body: BodyState) -> float:
        """Return how much lower the centre of mass must be for the legs to reach the feet."""
        soles = self.soles(body).copy()
        if self.swing is not None:
            soles[self.swing.step.side, :2] = self.swing.step.place
        ahead = body.rotation(1)[:2, 0] / np.linalg.norm(body.rotation(1)[:2, 0])
        off = (soles - body.com)[
            :, :2
        ]  # over the ground: a pelvis that leans brings no foot nearer
        along, left = off @ ahead, off @ np.array([-ahead[1], ahead[0]])
        aside = np.maximum(np.abs(left) - 0.5 * self._apart, 0.0)
        reach = min(float(np.hypot(along, aside).max()), 0.7 * self.leg)
        return float(self.leg - np.sqrt(self.leg**2 - reach**2) + BENT * self.leg)

    def centre(
        self, body: BodyState, standing: Standing, goal: Float[Array, " 3"]
    ) -> Float[Array, " 2"]:
        """Return the acceleration of the centre of mass once there were steps [m/s²].

        While a foot is in the air, pressure is as near to the capture point as the other allows.
        With both on the ground it leads the capture point to where the centre of mass is to be
        ([Englsberger2011]_), as far as the feet allow and a little more: arms and trunk help. More
        than that would be asked of them alone.
        """
        places = self.spheres(body)
        now = self.pendulum(body, places, standing)
        if self.swing is not None:
            side = 1 - self.swing.step.side
            pressure = EDGE * now.pressure[side] + (1 - EDGE) * now.feet[side]
        else:
            point = now.capture_point + now.shift
            wanted = point + CAPTURES * (now.capture_point - goal[:2])
            on = places[standing.site, :2] if len(standing.site) else now.feet
            pressure = nearest(on, wanted, -HELP)
        return now.omega**2 * (now.com - pressure)

    def rows(self, state: State) -> list[Rows]:
        """Return what the foot in the air is to do."""
        body = state.body
        if self.swing is None:
            both = [rows for k in (0, 1) for rows in self._stands(state, k)]
            return [self._upright(body), *both]
        side = self.swing.step.side
        place, velocity = self.soles(body)[side], body.velocity(self._soles)[side]
        J, bias = body.jacobian(self._soles)[side], body.bias_acceleration(self._soles)[side]
        target = np.array([*self.swing.step.place, place[2]])
        level = self._level_at(state, target)
        asked = self.swing.asked(state.time, place, velocity, level, self.leg)
        turn = self._level(state, side, TURN)
        stands = self._stands(state, 1 - side)
        return [self._upright(body), Rows(J, asked - bias, FOOT), turn, *stands]

    def _upright(self, body: BodyState) -> Rows:
        """Return the rows that keep the trunk from leaning."""
        trunk = self.human.trunk
        spin, up = body.angular_jacobian(trunk)[:2], body.rotation(trunk) @ self._up
        off = np.array([-up[1], up[0]])  # the axis about which it leans, with its sine
        return Rows(spin, -(LEANS**2) * off - 2 * LEANS * (spin @ body.qvel), TRUNK)

    def _stands(self, state: State, side: int) -> list[Rows]:
        """Return the rows of a foot that stands, or is about to: flat, and where it is."""
        body, sole = state.body, self._soles
        J, velocity = body.jacobian(sole)[side], body.velocity(sole)[side]
        still = -SLOWED * velocity[:2] - body.bias_acceleration(sole)[side, :2]
        return [self._level(state, side, STANDS), Rows(J[:2], still, FOOT)]

    def _level(self, state: State, side: int, weight: float) -> Rows:
        """Return the rows that lay a foot along the ground; one in the air faces forward, too."""
        body, foot, ground = state.body, self.feet[side], state.world.ground
        turn, spin = body.rotation(foot), body.angular_jacobian(foot)
        normal = ground.normal_at(body.origin(foot))
        flies = self.swing is not None and self.swing.step.side == side
        ahead = body.rotation(1)[:, 0] if flies else turn[:, 0]
        ahead = ahead - (ahead @ normal) * normal
        ahead /= np.sqrt(ahead @ ahead)
        wanted = np.array([ahead, (normal @ CROSS).reshape(3, 3) @ ahead, normal])
        M = turn @ wanted  # the sum of the cross products of the axes is in what is not symmetric
        off = 0.5 * np.array([M[1, 2] - M[2, 1], M[2, 0] - M[0, 2], M[0, 1] - M[1, 0]])
        return Rows(spin, 200.0 * off - 28.0 * (spin @ body.qvel), weight)


def _way(along: float, left: float) -> str:
    """Return in words how far a foot went, in centimetres."""
    parts = []
    for size, more, less in ((along, "forward", "back"), (left, "to the left", "to the right")):
        if abs(size) >= TOLD:
            parts.append(f"{100 * abs(size):.0f} cm {more if size > 0 else less}")
    return " and ".join(parts) or "on the spot"
