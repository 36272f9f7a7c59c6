"""Bones of a body as other programs name them: one tree for every joint set and every foot.

Each part of the anatomy (:mod:`plantigrade.models.anatomy`) is a bone, also where a joint set welds
it to its parent: then it never turns against it. A spine always has three bones, a neck two, and
a foot as many as it has parts. Names other than the package's own leave out what a rig lacks, and
what is left out is part of its parent.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.data_files import toml_tree
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.human import require_scaled
from plantigrade.models.landmarks import attachments
from plantigrade.models.skeleton import all_parts
from plantigrade.side_names import split_side

_TREE = toml_tree("plantigrade.exchange", "bones.toml")
_ENDS: dict[str, str] = _TREE["ends"]
"""Part → landmark where its bone ends, if no bone follows."""
RIGS: dict[str, dict[str, str]] = _TREE["rigs"]
"""Rig → names of its bones by part."""

_WORDS = {"r": {"Side": "Right", "s": "r", "S": "R"}, "l": {"Side": "Left", "s": "l", "S": "L"}}


@dataclass(frozen=True)
class Bone:
    """A bone, fixed to a body of the model."""

    name: str  #: Its name in the rig
    part: str  #: The part of the anatomy, with side
    parent: int  #: Index of the bone above it; -1 for the hips
    body: str  #: Name of the body
    position: Float[Array, "3"]  #: Its joint in the frame of the body [m]
    rest: Float[Array, "3"]  #: Its joint in the zero pose, from the hips' [m]
    #: Where it ends in the frame of the body [m]; NaN where another bone follows
    end: Float[Array, "3"]


def bones_of(human: Human, rig: str = "plantigrade") -> tuple[Bone, ...]:
    """Return the bones of a person, parents first.

    The joint of the hips is midway between the hip joints.

    Args:
        rig: One of :data:`RIGS`.
    """
    require_scaled(human, "a skeleton of bones")
    if rig not in RIGS:
        raise ParameterError(f"{rig=} must be one of {', '.join(RIGS)}")
    # a foot of many parts has its first toes where others have one part
    names = {**RIGS[rig], "medial_phalanges": RIGS[rig]["toes"]}
    skeleton, marks = human.skeleton, attachments(human)
    middle = np.mean([skeleton.origins[f"femur_{side}"] for side in SIDES], axis=0)
    parts = {
        part.name: part.parent
        for part in all_parts(human.dimensions, human.sex, human.mass, human.feet)
    }
    chosen = [name for name in parts if split_side(name)[0] in names]
    above = {name: _bone_above(name, parts, chosen) for name in chosen}
    found: list[Bone] = []
    for part in chosen:
        plain, side = split_side(part)
        body, offset = skeleton.parts[part]
        rest, place = skeleton.origins[part] - middle, offset
        if not above[part]:
            rest, place = np.zeros(3), offset + middle
        end = np.full(3, np.nan)
        if part not in above.values():
            mark = marks[f"{_ENDS[plain]}_{side}" if side else _ENDS[plain]]
            # A landmark may move with another body than the bone that ends there.
            end = mark.position + _origin(human, mark.body) - _origin(human, body)
        parent = chosen.index(above[part]) if above[part] else -1
        name = names[plain].format(**_WORDS.get(side, {}))
        found.append(Bone(name, part, parent, body, place, rest, end))
    return tuple(found)


def bone_poses(
    bones: tuple[Bone, ...],
    human: Human,
    origins: Float[Array, "n_frames n_bodies 3"],
    rotations: Float[Array, "n_frames n_bodies 3 3"],
    *,
    ends: bool = False,
) -> tuple[Float[Array, "n_frames n_bones 3"], Float[Array, "n_frames n_bones 3 3"]]:
    """Return the joints of bones, or their ends, and their rotations in the world.

    Args:
        origins: Origins of all bodies but the world [m].
        ends: Whether their ends are asked for, NaN where another bone follows.
    """
    body = [human.body(bone.body) - 1 for bone in bones]
    local = np.array([bone.end if ends else bone.position for bone in bones])
    turned = np.einsum("nbij,bj->nbi", rotations[:, body], local)
    return origins[:, body] + turned, rotations[:, body]


def _bone_above(name: str, parts: Mapping[str, str], chosen: list[str]) -> str:
    above = parts[name]
    while above and above not in chosen:
        above = parts[above]
    return above


def _origin(human: Human, body: str) -> Float[Array, "3"]:
    """Return the origin of a body in the pelvis frame, zero pose [m]."""
    bodies = {each.name: each for each in human.skeleton.bodies}
    place = np.zeros(3)
    while bodies[body].parent:
        place, body = place + bodies[body].position, bodies[body].parent
    return place
