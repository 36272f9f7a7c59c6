"""Every body of the package, random states and mirror images."""

from functools import cache

import numpy as np

from plantigrade.models import FEET, JOINT_SETS, Human
from plantigrade.side_names import split_side

PRESETS = [(joints, feet) for joints in JOINT_SETS for feet in FEET]
SEXES = ("female", "male")


@cache
def person(joints: str, feet: str, sex: str = "male") -> Human:
    """A person of one preset, built once for all tests."""
    return Human.create(1.74, 71.0, sex, joints, feet)


def random_state(human: Human, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A random configuration within the joint ranges, with random orientation and velocity."""
    low, high = human.limits
    q = np.empty(human.model.nq)
    q[:3] = rng.normal(size=3)
    q[3:7] = rng.normal(size=4)
    q[3:7] /= np.linalg.norm(q[3:7])
    q[7:] = rng.uniform(low, high)
    return q, rng.normal(size=human.model.nv)


def other_side(name: str) -> str:
    """The name for the other side of the body."""
    plain, side = split_side(name)
    return plain + {"r": "_l", "l": "_r", "": ""}[side]


def velocity_mirror(human: Human) -> np.ndarray:
    """The matrix that maps a velocity to that of the mirror image in the x-z plane."""
    names = human.coordinates
    matrix = np.zeros((6 + len(names), 6 + len(names)))
    matrix[:6, :6] = np.diag([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    for i, name in enumerate(names):
        midline = split_side(name)[1] == ""
        sign = -1.0 if midline and name.endswith(("_bending", "_rotation")) else 1.0
        matrix[6 + names.index(other_side(name)), 6 + i] = sign
    return matrix


def mirrored(human: Human, q: np.ndarray) -> np.ndarray:
    """The mirror image of a configuration in the x-z plane."""
    result = q.copy()
    result[:7] *= [1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0]
    result[7:] = velocity_mirror(human)[6:, 6:] @ q[7:]
    return result
