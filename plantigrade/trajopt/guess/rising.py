"""Postures that a first guess of getting up from the floor passes through.

They only begin the search: inverse kinematics puts hands, knees and feet where the plan has them
(:mod:`~plantigrade.trajopt.guess.in_contact`), and the solver leaves the rest.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import limb_site
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, PELVIS
from plantigrade.trajopt.guess.foot_motion import with_toes
from plantigrade.trajopt.guess.in_contact import KNEELING
from plantigrade.trajopt.guess.postures import standing_posture

Angles = Mapping[str, float]
"""Angles by the name of a coordinate without its side [rad]."""


@dataclass(frozen=True)
class KeyPosture:
    """A posture on the way up; angles that are not named are those of standing."""

    back: float  #: Pelvis behind its place in standing [thigh]
    low: float  #: Pelvis below its place in standing, of the way down to upright kneeling [1]
    rear: Angles  #: Leg whose knee leaves the floor last [rad]
    front: Angles  #: The other leg [rad]
    trunk: Angles = field(default_factory=dict)  #: Pelvis, trunk, neck and both arms [rad]

    def coordinates(self, human: Human, front: str) -> Float[Array, " nv"]:
        """Return the coordinates of a person whose front leg is on a side [rad, m]."""
        q, d, rear = standing_posture(human), human.dimensions, opposite(front)
        down = d.ankle_height + d.shank - limb_site(human, f"knee_{rear}").radius
        q[3:6] += [-self.back * d.thigh, 0.0, -self.low * down] @ OPENSIM_TO_WORLD
        named = {f"{n}_{side}": x for n, x in self.trunk.items() for side in SIDES}
        for side, leg in ((rear, self.rear), (front, self.front)):
            named |= {f"{n}_{side}": x for n, x in with_toes(human, leg).items()}
        named |= self.trunk
        for i, name in enumerate(PELVIS + human.coordinates):
            q[i] = named.get(name, q[i])
        return q


_CRAWLING = {**KNEELING, "hip_flexion": 1.5, "knee_angle": KNEELING["knee_angle"] - 0.1}
_ON_HANDS = {
    "pelvis_tilt": -1.45, "neck_extension": 0.5, "arm_flex": 1.75, "wrist_flex": -1.15,
    "pro_sup": 2.8, "elbow_flex": 0.1,
}  # fmt: skip
_FOLDED = {**_ON_HANDS, "pelvis_tilt": -1.0, "lumbar_extension": -0.6, "elbow_flex": 0.3}


@dataclass(frozen=True)
class RisingPostures:
    """Postures on the way up, in order of time.

    All are estimates: angles at which limbs rest where the plan has them and clear each other, of
    a person of mean proportions. Knees lie on the floor where the thigh is upright
    (:data:`~plantigrade.trajopt.guess.in_contact.KNEELING`).
    """

    all_fours: KeyPosture = KeyPosture(
        back=1.25, low=1.0, rear=_CRAWLING, trunk=_ON_HANDS,
        front={
            **_CRAWLING, "ankle_angle": -0.95, "mtp_angle": 0.0, "hip_rotation": 0.15
        },
    )  # fmt: skip
    """Thighs upright, trunk level on stretched arms, one foot on its toes, one on its instep."""
    foot_through: KeyPosture = KeyPosture(
        back=0.95, low=1.0, rear={**_CRAWLING, "hip_flexion": 1.0}, trunk=_FOLDED,
        front={
            "knee_angle": 2.2, "hip_flexion": 2.0, "ankle_angle": 0.2, "hip_adduction": -0.2,
            "hip_rotation": 0.15,
        },
    )  # fmt: skip
    """The front thigh close to the trunk and 11° out: the knee passes between the arms."""
    astride: KeyPosture = KeyPosture(
        back=0.65, low=1.1, rear={**KNEELING, "hip_flexion": 0.3}, trunk=_FOLDED,
        front={"knee_angle": 1.9, "hip_flexion": 2.1, "ankle_angle": 0.2},
    )  # fmt: skip
    """The front foot between the hands, the pelvis low between it and the rear knee."""
    upright: KeyPosture = KeyPosture(
        back=0.8, low=1.0, rear=KNEELING, trunk={"pelvis_tilt": -0.5, "arm_flex": 0.4},
        front={"knee_angle": 1.65, "hip_flexion": 1.5, "ankle_angle": 0.1},
    )  # fmt: skip
    """On one knee, the trunk on its way up after the hands have left the floor."""
    half_kneeling: KeyPosture = KeyPosture(
        back=1.0, low=1.0, rear={**KNEELING, "hip_flexion": 0.0},
        front={"knee_angle": 1.65, "hip_flexion": 1.5, "ankle_angle": 0.1},
    )  # fmt: skip
    """On one knee, trunk upright above it, the front shank almost upright."""
    pushing: KeyPosture = KeyPosture(
        back=0.4, low=0.25,
        rear={"knee_angle": 1.2, "hip_flexion": -0.1, "ankle_angle": 0.2, "mtp_angle": 0.9},
        front={"knee_angle": 1.0, "hip_flexion": 1.0},
    )  # fmt: skip
    """The rear knee off the floor, both legs stretching, the rear foot on bent toes."""
    toe_off: KeyPosture = KeyPosture(
        back=0.0, low=0.25, rear={"knee_angle": 1.1, "mtp_angle": 0.9},
        front={"knee_angle": 0.6, "hip_flexion": 0.6},
    )  # fmt: skip
    """Above the front foot, as the rear foot leaves the floor."""
    swing: KeyPosture = KeyPosture(
        back=0.0, low=0.0, rear={"knee_angle": 1.2, "hip_flexion": 0.3}, front={}
    )
    """The rear foot on its way forward, its knee bent to clear the floor."""
    strike: KeyPosture = KeyPosture(
        back=0.0, low=0.08,
        rear={"knee_angle": 0.3, "hip_flexion": 0.15, "ankle_angle": 0.15},
        front={"knee_angle": 0.3, "hip_flexion": 0.15, "ankle_angle": 0.15},
    )  # fmt: skip
    """Both feet side by side, knees not yet straight."""
