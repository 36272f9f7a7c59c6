r"""Angles between the segments of a multi-segment foot, as clinicians define them.

Segments and signs are those of the Oxford Foot Model [Carson2001]_, [Stebbins2006]_: hindfoot
against tibia, forefoot against hindfoot and tibia, hallux against forefoot. Each is turned first
about the left axis of the segment above (dorsiflexion), then about the vertical one that this
carried along (adduction, internal rotation), then about its own forward axis (supination,
inversion). All are positive in the sense they are named for, on both sides.

Which of our bodies plays which part, and where the anatomy differs:

* *hindfoot* is the body ``heel``, the calcaneus. Our talus belongs to the body ``foot``.
* *forefoot* is the row of metatarsals. Ours are two bodies, the medial three in ``foot`` (with
  the tarsal bones) and the lateral two; the forefoot's rotation is the one that carries the ten
  ends of the metatarsals, as they lie in the zero pose, closest to where they are. Since talus
  and medial metatarsals are one body, the arch cannot bend between them: of the plantarflexion
  of the forefoot at push-off a part is missing, and the hallux makes up for it.
* *hallux* is ``medial_phalanges``, the first three toes as one. One marker shows it, so only its
  dorsiflexion is given.

An angle is zero in the zero pose of the person (standing, soles flat, feet straight ahead); the
Oxford Foot Model has no such pose and takes its axes from markers, so a constant lies between.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.models.feet import point
from plantigrade.models.parts import MIRROR
from plantigrade.motion import Table

# Segment pair → its angles, in the order they are turned: about left (backwards), up and forward.
FOOT_ANGLES: dict[str, tuple[str, ...]] = {
    "hindfoot": ("dorsiflexion", "internal_rotation", "inversion"),
    "forefoot": ("dorsiflexion", "adduction", "supination"),
    "forefoot_to_tibia": ("dorsiflexion", "adduction", "supination"),
    "hallux": ("dorsiflexion",),
}
_SEGMENTS = {
    "hindfoot": ("tibia", "hindfoot"),
    "forefoot": ("hindfoot", "forefoot"),
    "forefoot_to_tibia": ("tibia", "forefoot"),
    "hallux": ("forefoot", "hallux"),
}
_METATARSALS = tuple(f"{end}_{k}" for k in range(1, 6) for end in ("base", "metatarsal"))
_LATERAL = {"base_4", "metatarsal_4", "base_5", "metatarsal_5"}
# The Oxford Foot Model's right side in our axes; the left is its mirror image.
_SIGNS = {"r": np.array([-1.0, 1.0, 1.0]), "l": np.array([-1.0, -1.0, -1.0])}


def foot_angles(
    human: Human, time: Float[Array, " n_frames"], qpos: Float[Array, "n_frames nq"]
) -> Table:
    """Return the angles between foot segments over time.

    Args:
        human: A person with multi-segment feet.
        time: Time of each frame [s].
        qpos: Configuration of each frame.

    Returns:
        Columns ``hindfoot_dorsiflexion_r``, ``forefoot_to_tibia_adduction_l``, …: the pairs of
        :data:`FOOT_ANGLES`, their angles, the sides [rad].

    Raises:
        ParameterError: If the person's feet are of another kind.
    """
    names, columns = [], []
    for side, rotations in segment_rotations(human, qpos).items():
        for pair, kinds in FOOT_ANGLES.items():
            above, below = _SEGMENTS[pair]
            angles = joint_angles(rotations[above], rotations[below], side)
            for k, what in enumerate(kinds):
                names.append(f"{pair}_{what}_{side}")
                columns.append(angles[:, k])
    return Table(tuple(names), np.asarray(time), np.stack(columns, axis=1))


def joint_angles(
    above: Float[Array, "n 3 3"], below: Float[Array, "n 3 3"], side: str
) -> Float[Array, "n 3"]:
    """Return dorsiflexion, adduction and supination of one segment against the one above [rad].

    Rotations are from the segments' axes (forward, left, up) to the world's.
    """
    from scipy.spatial.transform import Rotation

    relative = np.swapaxes(above, 1, 2) @ below
    return Rotation.from_matrix(relative).as_euler("YZX") * _SIGNS[side]


def segment_rotations(
    human: Human, qpos: Float[Array, "n_frames nq"]
) -> dict[str, dict[str, np.ndarray]]:
    """Return side → segment → rotation from its axes (parallel in the zero pose) to the world's.

    Raises:
        ParameterError: If the person's feet are not multi-segment.
    """
    if human.feet != "multi-segment":
        raise ParameterError(
            f"a person with {human.feet} feet has no foot segments; make one with multi-segment "
            "feet (--feet multi-segment)"
        )
    ends = [_metatarsal_end(human, name, side) for side in SIDES for name in _METATARSALS]
    bodies, local, rest = zip(*ends, strict=True)
    points = PointSet(human, bodies, np.array(local))
    x = np.empty((len(qpos), len(bodies), 3))
    turned = np.empty((len(qpos), human.model.nbody, 3, 3))
    for k, state in enumerate(sweep(human, qpos)):
        x[k], turned[k] = state.position(points), state.rotations
    n = len(_METATARSALS)
    result = {}
    for i, side in enumerate(SIDES):
        mine = slice(i * n, (i + 1) * n)
        result[side] = {
            "tibia": turned[:, human.body(f"tibia_{side}")],
            "hindfoot": turned[:, human.body(f"heel_{side}")],
            "forefoot": closest_rotation(np.array(rest[mine]), x[:, mine]),
            "hallux": turned[:, human.body(f"medial_phalanges_{side}")],
        }
    return result


def closest_rotation(
    rest: Float[Array, "n_points 3"], moved: Float[Array, "n_frames n_points 3"]
) -> Float[Array, "n_frames 3 3"]:
    """Return the rotations that carry points at rest closest to where they went ([Kabsch1976]_)."""
    a = rest - rest.mean(axis=0)
    b = moved - moved.mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.einsum("fpi,pj->fij", b, a))
    u[..., :, 2] *= np.linalg.det(u @ vt)[:, None]
    return u @ vt


def _metatarsal_end(human: Human, name: str, side: str) -> tuple[str, np.ndarray, np.ndarray]:
    """Return body, place in it and place in the foot at rest of an end of a metatarsal [m]."""
    place = point(name, human.dimensions) * (MIRROR if side == "r" else 1.0)
    part = f"lateral_metatarsal_{side}" if name in _LATERAL else f"foot_{side}"
    body, offset = human.skeleton.parts[part]
    shift = human.skeleton.origins[f"foot_{side}"] - human.skeleton.origins[part]
    return body, place + shift + offset, place
