"""The plan of a walk: where and when the swinging foot lands, and what the mass is off."""

from collections.abc import Callable
from dataclasses import replace
from math import atan, cos, exp, sin, sqrt

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.phase import Gait
from plantigrade.control.gait.planner import FootstepSettings
from plantigrade.control.pendulum.landing import Landing, Reach, landing
from plantigrade.control.pendulum.landing_laws import LandingLaw, Strike
from plantigrade.control.pendulum.scaled_reference import ScaledReference
from plantigrade.control.pendulum.swing import SwingSettings, detours
from plantigrade.kinematics.state import State
from plantigrade.models import Human

ASTRAY = 0.4
"""Who is farther than this from where the recording would be by now does not hurry back more
[leg lengths]; along the path what is lost beyond it stays lost."""
TIPTOE = 0.12
"""A trailing leg is longer by its ankle [leg lengths]."""
LOWEST, RISING = 0.2, 0.5
"""So much lower the body goes for far feet, at most [leg lengths]; it comes up again in this time
[s], lest it be thrown up between steps."""
REGAIN = 0.15
"""Rate at which a lasting offset from the path is countered [1/s]."""
ASIDE = 0.1
"""From this deviation to the side on a foot goes its own way, no longer along with the recorded one
[leg lengths]."""
ANEW = 0.5
"""Time constant with which the line of a walk that turns goes with the walker [s]."""


class Plan:
    """The plan of one walk, made anew at every tick.

    Args:
        gait: Phase and feet of the walk; its swinging foot is led to the landing.
        reference: The walk.
        law: By which feet land.
        leg: Length of the leg, hip to ankle [m].
        hip: Height of the mass above the hips [m].
        reaction: How far the extrapolated centre goes along with a foot that is led elsewhere, by
            its distance (:func:`reaction_of`).
        step: From one tick to the next [s].
        swing: How feet swing.
        footsteps: Limits and costs of footsteps.

    Attributes:
        error: What the divergent component of motion is off the plan, world [m].
        shift: How far the feet that stand are beside the recording, by load, world [m].
        swept: How far the way has turned since each foot stands as it does, to the left [rad].
        beside: How far the pressure is beside the recording for that, world [m].
        path: How far ahead of the recording, or behind, the walk stays for good, world [m].
        lead: What counters a lasting offset, world [m].
        bent: How much lower than recorded the body goes for legs to reach their feet [m].
        turning: How fast the walk turns to the left [rad/s].
        heading: Returns by how much it will have turned after a time [s], to the left [rad], and
            how far inward the extrapolated centre of mass is to be then [m], and half the angle of
            the step that begins then [rad].
        toes: How far the swinging foot is to look into the turn [rad].
    """

    def __init__(
        self,
        gait: Gait,
        reference: ScaledReference,
        law: LandingLaw,
        leg: float,
        hip: float,
        reaction: float,
        step: float,
        swing: SwingSettings,
        footsteps: FootstepSettings,
    ):
        self.swing, self.footsteps = swing, footsteps
        self.gait, self.law, self.leg, self.hip, self.step = gait, law, leg, hip, step
        self.reaction = reaction
        self.reference = reference
        self.error, self.shift = np.zeros(2), np.zeros(3)
        self.path, self.lead = np.zeros(2), np.zeros(2)
        self.bent = self.turning = 0.0
        self.beside, self.swept = np.zeros(2), np.zeros(2)
        self.toes = 0.0
        self.heading: Callable[[float], tuple[float, float, float]] = lambda left: (0.0, 0.0, 0.0)

    def next(
        self,
        body: State,
        ref: Instant,
        places: Float[Array, "2 3"],
        rise: Float[Array, " 2"],
        level: Callable[[Array], float],
        push: Float[Array, " 2"],
        foothold: Callable[[int, Array, Array, float], Array] | None = None,
    ) -> Landing | None:
        r"""Return where and when the swinging foot lands; None where no single foot swings.

        A push is expected to die away with the time constant of the pendulum. An acceleration
        :math:`a \, e^{-\omega t}` does to the walk what a velocity of :math:`a / (2 \omega)` does.

        Args:
            body: The person now.
            ref: The recording at the phase of the gait.
            places: Where the feet are, world [m].
            rise: How far the ground about the person rises along x and y, by distance.
            level: Height of the ground at a place [m].
            push: What the person is felt to be pushed by [m/s²].
            foothold: How far from a place a foot is to land to stand well, given which foot, the
                place, the other foot [m] and in what time [s]; it lands there if absent.
        """
        gait, reference, footsteps = self.gait, self.reference, self.footsteps
        omega = reference.omega
        velocity = body.com_velocity[:2] + push / (2.0 * omega)
        xi = body.com[:2] + velocity / omega
        xi_ref = (ref.com + ref.com_velocity / omega)[:2]
        first, beta, offsets, self.shift = gait.carried()
        standing = gait.standing
        path = self._path()
        self.beside = np.zeros(2)
        self.swept += self.turning * self.step
        swinging = [f for f in gait.feet if not f.stands and f.number is not None]
        self.bent *= 1.0 - self.step / RISING
        if len(standing) != 1 or len(swinging) != 1:
            for f in standing:
                k = SIDES.index(f.side)
                if len(standing) == 1 or places[k, 0] > places[1 - k, 0]:
                    self._bend(level, body.com[:2], places[k, :2], ref.com, ref.foot_position[k])
            deviation = xi - xi_ref - path - [0.0, self.heading(0.0)[1]]
            if not standing:
                for f in swinging:
                    left = (f.touchdown - gait.phase) / reference.cadence
                    f.swing.lead(deviation + path, left, self.step)
                self.error = np.zeros(2)
                return None
            last = max((f.number for f in standing if f.number is not None), default=first)
            known = np.arange(first, first + len(beta)) <= last
            later = footsteps.decayed(beta[~known]) * footsteps.offset_decay
            newest = gait.offset(last)[:2] - path
            self.error = deviation - beta[known] @ (offsets[known, :2] - path) - later * newest
            return None
        foot, other = swinging[0], standing[0]
        assert foot.number is not None and other.number is not None
        left = max(foot.touchdown - gait.phase, 0.01) / reference.cadence
        then = reference.at(foot.touchdown)
        head, _, weights = reference.schedule.weights(foot.touchdown)
        before = np.arange(head, head + len(weights)) < foot.number
        i, k = SIDES.index(foot.side), SIDES.index(other.side)
        height = float(then.com[2] - then.foot_position[k, 2])
        angle, inward, self.toes = self.heading(left)
        strike = Strike(
            com=then.com[:2] + path + [0.0, inward],
            velocity=then.com_velocity[:2],
            height=height,
            stands=then.foot_position[k, :2] + path,
            lands=then.foot_position[i, :2] + path,
            axes=np.eye(2),
            omega=omega,
            kept=float(weights[before].sum()),
            later=footsteps.decayed(weights[~before]),
            slope=(atan(rise[0]), atan(rise[1])),
        )
        # By then the walk looks another way.
        com, turn = body.com[:2], turned(angle)
        here = com + (places[:, :2] - com) @ turn.T
        stands = com + turn @ (then.foot_position[k, :2] + gait.offset(other.number)[:2] - com)
        apart = foot.left * float(strike.lands[1] - strike.stands[1])
        lands, hip = com + (strike.lands - com) @ turn, body.origin(f"femur_{foot.side}")
        swings = body.rigid_points(np.array([body.human.body(f"foot_{foot.side}")]), places[[i]])
        box = Reach(
            axes=np.eye(2),
            stance_foot_size=self.swing.stance_foot_size,
            nominal=strike.lands - stands,
            side=foot.left,
            leg_length=self.leg,
            min_width=min(gait.settings.swing.min_foot_distance * self.leg, apart),
            swing_offset=here[i] - strike.lands,
            speed=turn @ swings.velocity[0, :2],
            hip=turn @ (hip - body.com)[:2],
            high=float(hip[2] - then.foot_position[i, 2]) - level(np.append(lands, 0.0)),
            rises=float(body.com_velocity[2]),
            moved=turn @ foot.swing.offset - path,
            moves=turn @ foot.swing.velocity,
            reaction=self.reaction,
            may_cross=not angle,
            settings=footsteps,
        )
        # The recording's own effective pivot, where the foot really stands.
        grown = exp(omega * left)
        xi_then = (then.com + then.com_velocity / omega)[:2]
        pivot = (xi_then - grown * xi_ref) / (1.0 - grown) + self.shift[:2]
        # It is ahead of the ankle along the foot, which stays as it stands while the way turns.
        if self.swept[k]:
            back = turned(-self.swept[k])
            pivot = places[k, :2] + (pivot - places[k, :2]) @ back
            ahead = ref.cop[:2] - ref.foot_position[k, :2]
            self.beside = ahead @ back - ahead
        self.swept[i] = -self.toes  # as it is to land
        pivot, speed = com + turn @ (pivot - com), turn @ velocity
        found = landing(self.law, com, speed, pivot, stands, left, strike, box)
        home = strike.lands + footsteps.offset_decay * (self.shift[:2] - path)
        self.error = exp(-omega * found.after) * strike.later * (found.free - home)
        self._bend(level, found.com, found.place, then.com, then.foot_position[i])
        self._bend(level, found.com, here[k], then.com, then.foot_position[k], TIPTOE)
        found = replace(
            found, place=com + (found.place - com) @ turn, free=com + (found.free - com) @ turn
        )
        if foothold is not None:
            shift = foothold(i, found.place, places[k, :2], found.after)
            found = replace(found, place=found.place + shift)
            self.error = self.error - np.exp(-omega * found.after) * strike.later * (turn @ shift)
        time = left / max(gait.rate, gait.settings.min_lead_rate)
        apart = abs(float((ref.foot_position[i] - ref.foot_position[k])[1]))
        other, goal, aside = places[k, :2], found.place, abs(float(self.error[1]))
        by = self._around(foot.left, places[i, :2] - other, goal - other, apart)
        if by is None and foot.swing.own is None and aside < ASIDE * self.leg:
            foot.swing.lead(goal - then.foot_position[i, :2], time, self.step)
        else:
            pace = gait.rate * reference.cadence * ref.foot_velocity[i, :2]
            real = np.stack([places[i, :2], swings.velocity[0, :2]])
            motion = np.stack([ref.foot_position[i, :2], pace])
            foot.swing.go(real, motion, goal, time, self.step, None if by is None else other + by)
        return found

    def _around(
        self, left: float, start: Float[Array, " 2"], end: Float[Array, " 2"], apart: float
    ) -> Float[Array, " 2"] | None:
        """Return the point by which a foot goes around the other one; None where it goes straight.

        Args:
            left: 1 for the left foot, -1 for the right.
            start: Where it is, from the other one [m].
            end: Where it lands, likewise [m].
            apart: How far aside of it the recorded one is now [m].
        """
        outward = np.array([1.0, left])
        ahead, sideways = self.swing.stance_foot_size
        margin = self.gait.settings.swing.passing_margin
        size = np.array([ahead * self.leg, min(sideways * self.leg, apart - margin)])
        if size[1] <= margin:  # the recorded feet cross over themselves
            return None
        points, around = detours(outward * start, (outward * end)[None], size)
        return outward * points[0] if around[0] else None

    def _bend(self, level, com, foot, com_ref, foot_ref, more: float = 0.0) -> None:
        """Let the body go down for one leg to reach its foot, if the recorded one needs it not.

        Args:
            level: Height of the ground at a place [m].
            com: The mass, horizontal [m].
            foot: The foot, likewise.
            com_ref: The mass in the recording [m].
            foot_ref: The foot in it [m].
            more: How much longer the leg is [leg lengths].
        """
        leg = (self.swing.max_leg_extension + more) * self.leg
        high = []
        for c, f in ((com, foot), (com_ref, foot_ref)):
            x, y = (c - f).tolist()[:2]
            high.append(sqrt(max(leg**2 - x * x - y * y, 0.0)))
        drop = level(np.array([*com, 0.0])) - level(np.array([*foot, 0.0]))
        spare = max(high[1] + self.hip - float(com_ref[2] - foot_ref[2]), 0.0)
        bent = min(high[1] - high[0], LOWEST * self.leg) + drop - spare
        self.bent = max(self.bent, bent)

    def _path(self) -> Array:
        """Return the place that feet are led back to, beside the recording's own [m].

        A recording is no walk of this body: it would stay beside its path. What it is beside it for
        long is led the other way.
        """
        far = ASTRAY * self.leg
        off = self.shift[:2] - self.path
        near = np.minimum(np.maximum(off, -far), far)
        self.path[0] += off[0] - near[0]
        if self.turning:  # nobody has to go back to the line of before
            self.path[1] += self.step / ANEW * off[1]
        self.lead -= self.step * REGAIN * near
        self.lead = np.minimum(np.maximum(self.lead, -far), far)
        return self.shift[:2] - near + self.lead


def reaction_of(human: Human) -> float:
    """Return how far the extrapolated centre goes along with a foot, by its distance.

    It is the angular momentum about the centre of mass of a straight leg that swings from the hip,
    by the speed of its foot, and by mass and height.

    Args:
        human: The person, who stands.
    """
    rest = State(human, human.standing())
    side = SIDES[0]
    flexion = human.model.joint(f"hip_flexion_{side}").dofadr[0]
    low = rest.origin(f"foot_{side}")[2]
    leg, height = rest.origin(f"femur_{side}")[2] - low, rest.com[2] - low
    return float(abs(rest.angular_momentum_jacobian[1, flexion]) / (leg * rest.mass * height))


def turned(angle: float) -> Float[Array, "2 2"]:
    """Return the rotation to axes that are turned to the left."""
    c, s = cos(angle), sin(angle)
    return np.array([[c, s], [-s, c]])
