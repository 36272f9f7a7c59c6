"""Identify the joints of a foreign skeleton by name or, failing that, by shape.

Names are cut into words (``mixamorig:LeftUpLeg``, ``Bip01 L Thigh``, ``thigh_l``, ``lfemur``),
the side is removed and the rest is looked up in :data:`SPELLINGS`. A joint is named after the bone
distal to it in some skeletons (``LeftLeg`` is the knee) and after itself in others (``LeftKnee``);
for ambiguous words (``shoulder``, ``hip``, ``foot``) the other joints of the skeleton decide.
Pelvis and thorax are the common ancestors of both hips and both shoulders. Without usable names,
the four longest limbs of the tree decide.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.data_files import spelling_tables
from plantigrade.errors import FitError

SPELLINGS, MIDLINE = spelling_tables("joint_spellings.csv")
REQUIRED_JOINTS = ("hip", "knee", "ankle")
FOREARM_RATIO = 0.95  # [1] usual forearm to upper arm ratio; tells the wrist from its neighbours

_IGNORED_WORDS = frozenset(
    "bip biped valve valvebiped mixamorig mixamo rig b j jnt jt joint bone def org character char "
    "cc base bnd bind sk skel skeleton sim actor subject jx ref hi m f jnts jts robot".split()
)
_SIDE = {"l": "l", "left": "l", "lt": "l", "r": "r", "right": "r", "rt": "r"}
_VOCABULARY = frozenset(w for words in SPELLINGS.values() for w in words)


@dataclass(frozen=True)
class JointMap:
    """Assignment of the joints of a skeleton."""

    #: Our name (``"knee_l"``, ``"pelvis"``, ``"head"``) → index of the joint
    joints: dict[str, int] = field(default_factory=dict)
    by: str = "names"  #: Method of identification, ``"names"`` or ``"shape"``
    #: Whether left and right were exchanged because the feet pointed backwards
    swapped: bool = False

    def __getitem__(self, name: str) -> int:
        """Return the index of a joint; it must exist."""
        return self.joints[name]

    def get(self, name: str) -> int | None:
        """Return the index of a joint, None if the skeleton lacks it."""
        return self.joints.get(name)

    def both(self, name: str) -> bool:
        """Whether the joint exists on both sides."""
        return f"{name}_r" in self.joints and f"{name}_l" in self.joints


def split_name(name: str) -> tuple[str, str]:
    """Return a joint's word and side (``"l"``, ``"r"`` or ``""``).

    Example:
        >>> [split_name(n) for n in ("mixamorig:LeftUpLeg", "Bip01 L Thigh", "lfemur", "Hips")]
        [('upleg', 'l'), ('thigh', 'l'), ('femur', 'l'), ('hips', '')]
    """
    plain = re.split(r"[:|]", name)[-1]
    plain = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", plain)
    tokens = [t.lower() for t in re.findall(r"[A-Za-z]+", plain)]
    kept = [t for t in tokens if t not in _IGNORED_WORDS] or tokens
    sides = [t for t in kept if t in _SIDE]
    words = [t for t in kept if t not in _SIDE]
    word = "".join(words)
    if sides:
        return word, _SIDE[sides[0]]
    for prefix in ("left", "right", "l", "r"):
        for rest in (word.removeprefix(prefix), word.removesuffix(prefix)):
            sure = len(prefix) > 1 or rest in _VOCABULARY
            if rest != word and rest and sure and word not in _VOCABULARY:
                return rest, prefix[0]
    return word, ""


def identify(
    names: Sequence[str],
    parents: Sequence[int],
    rest: Float[Array, "n_joints 3"],
    given: Mapping[str, str] | None = None,
) -> JointMap:
    """Identify the joints of a skeleton.

    Args:
        names: Joint names, parents before children.
        parents: Index of each joint's parent, -1 for the root.
        rest: Joint positions in the rest pose, x forward, y left, z up [m].
        given: User's assignment, our name → the file's (``{"hip_l": "Bone7"}``).
    """
    tree = _Tree(names, parents, rest)
    named = _given(names, given or {})
    found = _by_name(tree, named)
    by, swapped = "names", False
    if not all(f"{j}_{s}" in found for j in REQUIRED_JOINTS for s in SIDES):
        shaped, swapped = _by_shape(tree)
        by, found = "shape", {**shaped, **named}
    missing = [f"{j}_{s}" for j in REQUIRED_JOINTS for s in SIDES if f"{j}_{s}" not in found]
    if missing:
        raise FitError(
            f"the joints {', '.join(missing)} cannot be identified by name or shape; "
            f"the skeleton has {', '.join(names[:60])}{' …' if len(names) > 60 else ''}. "
            "Name them like LeftUpLeg, LeftLeg, LeftFoot, RightUpLeg, … (or hip_l, knee_l, "
            'ankle_l), or assign them: {"hip_l": "name in the file", …}'
        )
    found.setdefault("pelvis", tree.common(found["hip_r"], found["hip_l"]))
    if "shoulder_r" in found and "shoulder_l" in found:
        thorax = tree.common(found["shoulder_r"], found["shoulder_l"])
        if thorax != found["pelvis"]:
            found.setdefault("thorax", thorax)
    return JointMap(found, by, swapped)


def _given(names: Sequence[str], given: Mapping[str, str]) -> dict[str, int]:
    ours = {f"{j}_{s}" for j in SPELLINGS for s in SIDES} | {*MIDLINE, "pelvis", "thorax"}
    for name, file_name in given.items():
        if name not in ours:
            raise FitError(f"there is no joint {name!r}; there are {', '.join(sorted(ours))}")
        if file_name not in names:
            raise FitError(f"the skeleton has no {file_name!r}; it has {', '.join(names)}")
    return {name: names.index(file_name) for name, file_name in given.items()}


class _Tree:
    """Ancestry and bone lengths of a skeleton."""

    def __init__(self, names: Sequence[str], parents: Sequence[int], rest: np.ndarray):
        self.names, self.parents, self.rest = names, parents, rest
        self.length = np.zeros(len(names))
        self.leaves = [i for i in range(len(names)) if i not in parents]
        for i, p in enumerate(parents):
            if p >= 0:
                self.length[i] = np.linalg.norm(rest[i] - rest[p])

    def path(self, i: int) -> list[int]:
        """Return the joints from the root to ``i``."""
        path = []
        while i >= 0:
            path.append(i)
            i = self.parents[i]
        return path[::-1]

    def under(self, i: int, ancestor: int) -> bool:
        return ancestor in self.path(i)

    def common(self, a: int, b: int) -> int:
        """Return the last common ancestor of two joints."""
        return next(i for i in reversed(self.path(a)) if self.under(b, i))

    def distance(self, a: int, b: int) -> float:
        return float(np.linalg.norm(self.rest[a] - self.rest[b]))


def _by_name(tree: _Tree, named: dict[str, int]) -> dict[str, int]:
    words = [split_name(name) for name in tree.names]
    found = dict(named)
    for side in SIDES:
        taken: set[int] = set(named.values())

        def pick(joint: str, above: str | None, side: str = side, taken: set[int] = taken) -> None:
            """Assign the best candidate for this joint below another joint."""
            key = f"{joint}_{side}"
            if key in found:
                return
            parent = found.get(f"{above}_{side}") if above else None
            for word in SPELLINGS[joint]:
                for i, name in enumerate(words):
                    free = name == (word, side) and i not in taken
                    if free and (parent is None or (i != parent and tree.under(i, parent))):
                        taken.add(i)
                        found[key] = i
                        return

        # The chain starts at the hip: "leg" means the shank after an upper leg, otherwise the
        # thigh.
        for chain in (("hip", "knee", "ankle", "ball", "toe_end"), ("shoulder", "elbow")):
            for above, joint in zip((None, *chain), chain, strict=False):
                pick(joint, above)
        _wrist(tree, words, found, side)
        taken.add(found.get(f"wrist_{side}", -1))
        pick("thumb", "elbow")
        for joint in ("index", "pinky", "knuckle"):
            pick(joint, "wrist")
        above = found.get(f"shoulder_{side}")
        for i in [] if above is None else tree.path(above)[:-1]:
            if words[i][1] == side and words[i][0] in SPELLINGS["clavicle"]:
                found.setdefault(f"clavicle_{side}", i)
    for joint, spellings in MIDLINE.items():
        for word in spellings:
            at = [i for i, (w, s) in enumerate(words) if w == word and not s]
            if at and joint not in found:
                found[joint] = at[0]
    return found


def _wrist(tree: _Tree, words, found: dict[str, int], side: str) -> None:
    """Select wrist or hand by the forearm length.

    ASF's bone ``wrist`` is half the forearm, SMPL's ``hand`` lies in the knuckles.
    """
    shoulder, elbow = found.get(f"shoulder_{side}"), found.get(f"elbow_{side}")
    if elbow is None or shoulder is None or f"wrist_{side}" in found:
        return
    upper = tree.distance(shoulder, elbow)
    candidates = [
        i
        for i, (w, s) in enumerate(words)
        if s == side
        and w in SPELLINGS["wrist"]
        and i != elbow
        and tree.under(i, elbow)
        and tree.distance(i, elbow) > 1e-4
    ]
    if candidates and upper > 0:
        found[f"wrist_{side}"] = min(
            candidates, key=lambda i: abs(np.log(tree.distance(i, elbow) / upper / FOREARM_RATIO))
        )


def _by_shape(tree: _Tree) -> tuple[dict[str, int], bool]:
    """Identify limbs by the tree alone: legs end lowest, arms outermost, the head highest."""
    leaves, rest = tree.leaves, tree.rest
    found: dict[str, int] = {}

    def limb(leaf: int, joints: tuple[str, str, str], side: str) -> None:
        sign = 1.0 if side == "l" else -1.0
        path = [i for i in tree.path(leaf) if tree.length[i] > 1e-3 and sign * rest[i, 1] > 1e-2]
        if len(path) < 3:
            return
        pairs = [  # the longest two consecutive bones; the distal pair in a tie
            (round(min(tree.length[path[k + 1]], tree.length[path[k + 2]]), 2), k)
            for k in range(len(path) - 2)
        ]
        k = max(pairs)[1]
        for joint, i in zip(joints, path[k : k + 3], strict=True):
            found[f"{joint}_{side}"] = i
        if joints[0] == "hip" and len(path) > k + 3:
            found[f"ball_{side}"] = path[k + 3]

    for ends, joints in (
        (lambda i: -rest[i, 2], ("hip", "knee", "ankle")),
        (lambda i: abs(rest[i, 1]), ("shoulder", "elbow", "wrist")),
    ):
        for side, sign in (("l", 1.0), ("r", -1.0)):
            mine = [i for i in leaves if sign * rest[i, 1] > 1e-3]
            if joints[0] == "shoulder":
                used = {found.get("hip_l", -1), found.get("hip_r", -1)}
                mine = [i for i in mine if not used & set(tree.path(i))]
            if mine:
                limb(max(mine, key=ends), joints, side)
    above = [i for i in leaves if abs(rest[i, 1]) < 0.05]
    if above:
        top = max(above, key=lambda i: rest[i, 2])
        if rest[top, 2] > 0:
            found["head"] = top
    swapped = False
    if "ball_l" in found and "ball_r" in found:
        forward = sum(rest[found[f"ball_{s}"], 0] - rest[found[f"ankle_{s}"], 0] for s in SIDES)
        swapped = bool(forward < -0.02)
    return found, swapped
