"""A person as gait controllers see them: contact spheres, lengths and strength."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.spatial.conventions import rotation_matrix

SEAT = len(SIDES)
"""Side of the points that are on no foot."""


def world_sites(record: Record) -> tuple[ContactSite, ...]:
    """Return the contact spheres of the feet, and what else seats or the ground carry."""
    others = [s for s in record.sites if not s.side and not s.measured]
    return (*contact_sites(record.human), *others)


def leg_length(human: Human) -> float:
    """Return the height of the hip above the ankle in standing [m]."""
    standing = BodyState(human, human.standing())
    hip, ankle = (standing.origin(f"{bone}_{SIDES[0]}") for bone in ("femur", "foot"))
    return float(hip[2] - ankle[2])


@dataclass(frozen=True)
class SoleShape:
    """The sole of a foot by its contact spheres, from the ankle, in quiet standing."""

    heel: float  #: End of the heel ahead of the ankle, a negative number [m]
    heel_centre: float  #: Centre of its hindmost sphere, on which it stands, likewise [m]
    ball: float  #: Head of the first metatarsal ahead of the ankle [m]
    toes: float  #: Tip of the toes ahead of the ankle [m]
    half_width: float  #: Half the distance of the outermost spheres, of their centres [m]

    @property
    def length(self) -> float:
        """From heel to toes [m]."""
        return self.toes - self.heel

    @property
    def clear_way(self) -> Float[Array, " 2"]:
        """Half axes, ahead and sideways, of the ellipse that another ankle goes around [m]."""
        return np.array([self.toes, 2.0 * self.half_width])

    @classmethod
    def of(cls, human: Human) -> "SoleShape":
        """Return the sole of a person; where no sphere is a metatarsal, its ball is at two thirds.

        Raises:
            ParameterError: If the person has no contact sphere.
        """
        side, standing = SIDES[0], BodyState(human, human.standing())
        sites = [site for site in contact_sites(human) if site.side == side]
        if not sites:
            raise ParameterError("a sole needs contact spheres, and this person has none")
        body = f"foot_{side}"
        centres = standing.position(PointSet.of(human, sites)) - standing.origin(body)
        x, y = (centres @ standing.rotation(body))[:, :2].T
        radius = np.array([site.radius for site in sites])
        toes = float((x + radius).max())
        balls = [at for at, site in zip(x, sites, strict=True) if "metatarsal_1" in site.name]
        ball = float(balls[0]) if balls else 2.0 / 3.0 * toes
        end, width = float((x - radius).min()), float(np.ptp(y))
        return cls(end, float(x.min()), ball, toes, 0.5 * width)


@dataclass(frozen=True, eq=False)
class GaitPerson:
    """A person, as gait controllers see them.

    Attributes:
        human: The person.
        sites: Contact spheres.
        points: Their centres.
        radius: Their radii [m].
        side_of: Side of each sphere: 0 right, 1 left, :data:`SEAT`.
        of_side: Spheres of each side.
        sole: Shape of a sole.
        leg_length: Height of the hip above the ankle, standing [m].
        com_height: Height of the centre of mass above the hips, standing [m].
        leg_momentum: Angular momentum of a straight leg that swings from the hip, about the centre
            of mass, by the speed of its foot, mass and height: the part of its way by which the
            extrapolated centre of mass goes along with a foot.
        strength: Greatest torque of every hinge [N m].
    """

    human: Human
    sites: tuple[ContactSite, ...]
    points: PointSet
    radius: Float[Array, "n_sites 1"]
    side_of: Int[Array, " n_sites"]
    of_side: tuple[Int[Array, " _"], ...]
    sole: SoleShape
    leg_length: float
    com_height: float
    leg_momentum: float
    strength: Float[Array, " n_hinges"]

    @classmethod
    def of(cls, record: Record) -> "GaitPerson":
        """Return the person of a record, with the contact spheres of its world."""
        human, sites = record.human, world_sites(record)
        side_of = np.array([(*SIDES, "").index(s.side) for s in sites])
        standing = BodyState(human, human.standing())
        hip, ankle = (standing.origin(f"{bone}_{SIDES[0]}") for bone in ("femur", "foot"))
        flexion = human.model.joint(f"hip_flexion_{SIDES[0]}").dofadr[0]
        low, high = np.array(human.model.jnt_actfrcrange[1:]).T
        return cls(
            human=human,
            sites=sites,
            points=PointSet.of(human, sites),
            radius=np.array([[s.radius] for s in sites]),
            side_of=side_of,
            of_side=tuple((side_of == i).nonzero()[0] for i in range(SEAT + 1)),
            sole=SoleShape.of(human),
            leg_length=leg_length(human),
            com_height=float(standing.com[2] - hip[2]),
            leg_momentum=float(
                abs(standing.angular_momentum_jacobian[1, flexion])
                / ((hip[2] - ankle[2]) * standing.mass * (standing.com[2] - ankle[2]))
            ),
            strength=np.maximum(-low, high),
        )

    def least_flexion(self, qpos: Float[Array, "n nq"], ankles: Float[Array, "n 2 3"]) -> float:
        """Return by how much the legs of a motion are always shorter than in standing [m].

        Args:
            qpos: The motion, in MuJoCo's order; of this only the pelvis counts.
            ankles: Ankles of both sides in it, world [m].

        Returns:
            Height of the hip above the ankle in standing, less the greatest distance of a hip from
            its ankle; zero for legs that are ever as straight.
        """
        hips = np.array([self.human.model.body(f"femur_{side}").pos for side in SIDES])
        legs = qpos[:, None, :3] + hips @ np.swapaxes(rotation_matrix(qpos[:, 3:7]), 1, 2) - ankles
        return max(self.leg_length - float(np.linalg.norm(legs, axis=2).max()), 0.0)
