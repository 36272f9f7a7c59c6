r"""Solid limbs: legs do not pass through each other, arms not through trunk, thighs and each other.

One smooth row a limb and node. For all distances :math:`d_i` between a point of one limb and what
it must not enter, the row is

.. math:: d = -\frac{1}{\beta} \ln \sum_i e^{-\beta d_i} \le \min_i d_i,

so that a limit on it is on the safe side of every one. Points lie along the bones and edges of a
limb and have its thickness; what they must not enter are capsules, the closest point of whose axis
is found with a clamped parameter, and ellipsoids of the trunk, to which

.. math:: d(x) \approx \frac{k_0 (k_0 - 1)}{k_1}, \qquad
    k_0 = \lVert x / s \rVert, \quad k_1 = \lVert x / s^2 \rVert,

is exact on the surface and to first order near it, :math:`s` being the half sizes. Only angles of
the joints between the limbs enter: the pelvis is the frame.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan, Stance
from plantigrade.contact.site import Point
from plantigrade.dynamics.recursions import sparse
from plantigrade.models.parts import Solid
from plantigrade.motion.blends import quintic_rise
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.contact_body import Cache, ContactBody
from plantigrade.trajopt.terms.limb_shapes import (
    Rod,
    arm_spheres,
    free_arm_rods,
    leg_rods,
    load_spheres,
    sphere_count,
)
from plantigrade.trajopt.terms.term import Spaced, Term

SHARPNESS = 250.0  # :math:`\beta` [1/m]: of two equal distances the row is 2.8 mm short
ROUNDING_LENGTH = 1e-3  # [m] rounding of the distance to an axis
ROW_SCALE = 10.0  # [1/m] scale of rows, tenths of a metre
REFERENCE_HEIGHT = 1.74
"""Stature for the given margins [m]."""
LEG_DIAMETER = 0.1  # [m] approximate diameter of a leg
PASSING_DISTANCE = 0.35  # [m] sagittal distance of feet within which the legs are close
SAMPLE_SHARES = np.linspace(0.0, 1.0, 51)
LEG_POINTS = {"femur": 7, "tibia": 8}
"""Number of points along a thigh and a shank that are kept out of the other leg."""
PROXIMAL_POINTS = 2
"""Number of these, from the proximal end, that are left out: those of the upper third of a thigh,
and those next to the knee of a shank against the other thigh."""
BELLY_SPHERES = 4  # along the distal half of a thigh, next to a trunk that bends over it
LEGS, ARMS, GROUND = "solid legs", "solid arms", "arms above the ground"


@dataclass(frozen=True)
class SolidLimbs(Term):
    """Legs and feet do not enter each other, arms not trunk, head, thighs and each other.

    Nor does the trunk enter the thighs, an arm the ground, or a load in a hand trunk and thighs.

    A distance that is not finite sets no limit.
    """

    #: Distance that legs keep at nodes [m]; between nodes they may come nearer
    margin: float = 0.003
    #: Distance that arms keep from trunk, thighs and each other, of a person of
    #: :data:`REFERENCE_HEIGHT` [m]; in proportion for others, whose arms hang as near
    arms: float = 0.0025
    ground: float = 0.003  #: Distance that arms keep from the highest tread [m]
    #: Whether an arm keeps away from the thigh of the other side too, which only a thigh that is
    #: raised above the horizontal comes near; rows of arms then take a fifth longer
    opposite_thighs: bool = False
    #: Whether an arm keeps away from both shanks too, which only a person near the ground comes
    #: near
    shanks: bool = False
    #: Whether thighs keep away from shoulders and neck too, which only the knees of a person who
    #: sits on the ground come near
    shoulders: bool = False
    #: Whether a load in a hand hangs beside the thigh, as people carry it in walking. If it only
    #: has to stay outside both thighs, it swings behind the pelvis
    loads_beside: bool = False
    #: Whether an arm keeps away from both feet too, which come near a hand only in stepping over a
    #: high block
    feet: bool = False

    def spaced(self, plan: ContactPlan) -> tuple[Spaced, ...]:
        """Return when a swinging foot passes the other leg: that must not happen between nodes.

        It is taken to move smoothly, at :math:`1.875 L / T` where it is fastest.
        """
        found = []
        for one, two, other in _passings(plan) if np.isfinite(self.margin) else ():
            here, there, opposite = (np.array(x.footprint.position) for x in (one, two, other))
            length, duration = float(np.linalg.norm(there - here)), two.heel_strike - one.toe_off
            along = (opposite - here) @ (there - here) / length**2
            part = float(np.interp(along, quintic_rise(SAMPLE_SHARES), SAMPLE_SHARES))
            time, speed = one.toe_off + part * duration, 1.875 * length / duration
            near = PASSING_DISTANCE / speed
            found.append((time - near, time + near, LEG_DIAMETER / speed))
        return tuple(found)

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the rows."""
        near = self.arms * b.body.human.height / REFERENCE_HEIGHT
        tread = max((s.footprint.position[2] for s in b.plan.stances), default=0.0)
        for family, margin in (
            (legs, self.margin),
            (partial(arms, limbs=self), near),
            (arms_above_ground, self.ground + tread),
        ):
            if np.isfinite(margin):
                b.limit(b.add(family(b.body, len(b.nodes))), lower=ROW_SCALE * margin)


def legs(body: ContactBody, n_nodes: int) -> ConstraintFamily:
    """Return how far both legs are from each other [0.1 m]."""
    human = body.human

    def expression(ca: Any, q: Any, v: Any, a: Any, u: Any, p: Any) -> Any:
        at = _Placed(ca, body, q)
        d = []
        (thigh_r, shank_r, foot_r), (thigh_l, shank_l, foot_l) = (leg_rods(human, s) for s in SIDES)
        n_thigh, n_shank = LEG_POINTS.values()
        d += [at.apart(x, thigh_l) for x in thigh_r.points(n_thigh)[PROXIMAL_POINTS:]]
        d += [at.apart(x, shank_l) for x in shank_r.points(n_shank)]
        for shank, foot, others in ((shank_l, foot_l, foot_r), (shank_r, foot_r, foot_l)):
            for rod in others:
                for x in rod.points(sphere_count(human, rod)):
                    d += [at.apart(x, other) for other in (shank, *foot)]
        for shank, foot, thigh in ((shank_l, foot_l, thigh_r), (shank_r, foot_r, thigh_l)):
            raised = [x for rod in foot for x in rod.points(sphere_count(human, rod))]
            distal = shank.points(n_shank)[PROXIMAL_POINTS:]
            d += [at.apart(x, thigh) for x in (*distal, *raised)]
        return ROW_SCALE * _least(ca, d)

    return _family(body, n_nodes, LEGS, expression, ("distance of the legs",))


def arms(body: ContactBody, n_nodes: int, limbs: SolidLimbs) -> ConstraintFamily:
    """Return how far arms are from trunk, head, legs and each other, thighs from the trunk.

    Loads in the hands belong to the arms; ``limbs`` says what else they keep away from.
    """
    human = body.human
    loads_beside = limbs.loads_beside and any(load_spheres(human, side) for side in SIDES)
    words = {
        " and both thighs": limbs.opposite_thighs,
        " and shanks": limbs.shanks,
        " and feet": limbs.feet,
        " and shoulders": limbs.shoulders,
        " with loads beside": loads_beside,
    }

    def expression(ca: Any, q: Any, v: Any, a: Any, u: Any, p: Any) -> Any:
        at = _Placed(ca, body, q)
        rows = []
        trunk = [(b.name, s) for b in human.skeleton.bodies for s in b.solids
                 if s.kind == "ellipsoid"]  # fmt: skip
        for side in SIDES:
            load = load_spheres(human, side)
            near = SIDES if limbs.opposite_thighs or load else (side,)
            legs, d = [leg_rods(human, each)[0] for each in near], []
            legs += [leg_rods(human, each)[1] for each in SIDES] if limbs.shanks else []
            if limbs.feet:
                legs += [rod for each in SIDES for rod in leg_rods(human, each)[2]]
            for x in (*arm_spheres(human, side), *load):
                d += [at.apart(x, leg) for leg in legs]
                d += [at.distance(x, name, solid) for name, solid in trunk]
            own = leg_rods(human, side)[0]
            d += [at.beside(x, own, side) for x in load if loads_beside]
            rows.append(ROW_SCALE * _least(ca, d))
        right, left = (free_arm_rods(human, side) for side in SIDES)
        spheres = [x for rod in right for x in rod.points(sphere_count(human, rod))]
        d = [at.apart(x, rod) for x in spheres for rod in left]
        above = [(name, solid) for name, solid in trunk if name != human.body_names[0]]
        names = {name for name, _ in above} if limbs.shoulders else {}
        high = [Rod(b.name, s.a, s.b, s.radius) for b in human.skeleton.bodies
                if b.name in names for s in b.solids if s.kind == "capsule"]  # fmt: skip
        folded = []
        for side in SIDES:  # from its middle on: it begins next to the belly
            thigh = leg_rods(human, side)[0].distal_half
            spheres = thigh.points(sphere_count(human, thigh) if limbs.shoulders else BELLY_SPHERES)
            belly = [at.distance(x, *each) for x in spheres for each in above]
            belly += [at.apart(x, rod) for x in spheres for rod in high]
            folded.append(ROW_SCALE * _least(ca, belly))
        # From one of them on: arms far apart leave nothing of the exponentials themselves.
        arms_apart = ROW_SCALE * (d[0] + _least(ca, [x - d[0] for x in d]))
        return ca.vertcat(*rows, arms_apart, *folded)

    names = (
        *(f"distance of arm_{s}" for s in SIDES),
        "distance of the arms",
        *(f"distance of thigh_{s} and trunk" for s in SIDES),
    )
    family = ARMS + "".join(word for word, there in words.items() if there)
    return _family(body, n_nodes, family, expression, names)


def arms_above_ground(body: ContactBody, n_nodes: int) -> ConstraintFamily:
    """Return how high the lowest points of both arms are in the axes of the ground [0.1 m]."""
    spheres = {side: arm_spheres(body.human, side, corners=True) for side in SIDES}

    def expression(ca: Any, q: Any, v: Any, a: Any, u: Any, p: Any) -> Any:
        rows = []
        for own in spheres.values():
            points = [Point(x.body, tuple(map(float, x.a)), x.radius) for x in own]
            heights = body.symbolic.positions(points)(q)[2, :]
            # From one of them on: high arms leave nothing of the exponentials themselves.
            rows.append(heights[0] + _least(ca, [h - heights[0] for h in ca.horzsplit(heights)]))
        return ROW_SCALE * ca.vertcat(*rows)

    names = tuple(f"height of arm_{s}" for s in SIDES)
    return _family(body, n_nodes, GROUND, expression, names)


def _family(body: ContactBody, n_nodes: int, name: str, expression: Any, names: tuple[str, ...]):
    function = body.function(name, expression)
    return ConstraintFamily.free(
        name, function, names, n_nodes, unit="mm", scale=1000.0 / ROW_SCALE
    )


class _Placed:
    """Bodies placed in the frame of the pelvis, as expressions of the hinges."""

    def __init__(self, ca: Any, body: ContactBody, q: Any):
        self.ca, self.human = ca, body.human
        self._position, self._rotation = body.symbolic.frames()(ca.vertcat(ca.SX(6, 1), q[6:]))
        self._kept = Cache().get
        self._q, self._body = q, body

    def apart(self, x: Rod, rod: Rod) -> Any:
        """Return how far a sphere is from a capsule [m]."""
        ca, p = self.ca, self._at(x.body, x.a)
        a, b = self._at(rod.body, rod.a), self._at(rod.body, rod.b)
        key = "way", rod.body, tuple(rod.a), tuple(rod.b)
        way = self._kept(key, lambda: (b - a) / float(np.sum((rod.b - rod.a) ** 2)))
        length = float(np.sum((rod.b - rod.a) ** 2))
        off = p - a
        part = ca.fmin(ca.fmax(ca.dot(off, way), 0), 1) * length
        off = off - part * way
        return ca.sqrt(ca.dot(off, off) + ROUNDING_LENGTH**2) - (x.radius + rod.radius)

    def beside(self, x: Rod, thigh: Rod, side: str) -> Any:
        """Return how far a sphere is to the side of a thigh that hangs plumb from its hip [m].

        The side is along the level: along a pelvis that drops, the load would come in below it.
        """
        outward = -1.0 if side == "r" else 1.0
        off = self._at(x.body, x.a) - self._at(thigh.body, thigh.a)
        return outward * self.ca.dot(off, self._kept("level", self._level)) - (
            x.radius + thigh.radius
        )

    def distance(self, x: Rod, body: str, solid: Solid) -> Any:
        """Return about how far a sphere is from an ellipsoid [m]."""
        ca = self.ca
        p = self._kept(("seen", x.body, tuple(x.a), body), lambda: self._seen(x, body))
        one = (p - solid.a) / solid.b
        two = one / solid.b
        k0, k1 = (ca.sqrt(ca.dot(k, k) + 1e-6) for k in (one, two))
        return k0 * (k0 - 1) / k1 - x.radius

    def _level(self) -> Any:
        """Return the way to the left along the level, in the axes of the pelvis."""
        ca, sym = self.ca, self._body.symbolic
        pelvis = sym.frames()(self._q)[1][:, :3]
        up = ca.mtimes(pelvis.T, -sym.gravity / np.linalg.norm(sym.gravity))
        left = ca.SX([0.0, 1.0, 0.0]) - up[1] * up
        return left / ca.norm_2(left)

    def _seen(self, x: Rod, body: str) -> Any:
        """Return a point in the frame of another body."""
        p = self._at(x.body, x.a)
        if body == self.human.body_names[0]:
            return p
        i = self.human.body(body) - 1
        R = self._rotation[:, 3 * i : 3 * i + 3]
        return self.ca.mtimes(R.T, p - self._position[:, i])

    def _at(self, body: str, point: Array) -> Any:
        """Return a point of a body."""

        def make() -> Any:
            i = self.human.body(body) - 1
            R = self._rotation[:, 3 * i : 3 * i + 3]
            return self._position[:, i] + self.ca.mtimes(R, sparse(self.ca, point.reshape(3, 1)))

        return self._kept((body, tuple(point)), make)


def _least(ca: Any, distances: Sequence[Any]) -> Any:
    """Return a smooth number below all distances [m]."""
    every = ca.vertcat(*distances)
    return -ca.log(ca.sum1(ca.exp(-SHARPNESS * every))) / SHARPNESS


def _passings(plan: ContactPlan) -> Iterator[tuple[Stance, Stance, Stance]]:
    """Yield the stances before and after every swing past a standing foot, and the stance there."""
    stances = plan.unrolled()
    for side in SIDES:
        own = [s for s in stances if s.footprint.side == side]
        for one, two in pairwise(own):
            here, there = (np.array(s.footprint.position) for s in (one, two))
            for other in stances:
                opposite = np.array(other.footprint.position)
                stands = other.heel_strike <= one.toe_off and other.toe_off >= two.heel_strike
                if other.footprint.side != side and stands:
                    along = (opposite - here) @ (there - here)
                    if 0.0 < along < (there - here) @ (there - here):
                        yield one, two, other
