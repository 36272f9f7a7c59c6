"""A robot as a MuJoCo model: which of its bodies are which parts of a person."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import FileError, FitError, ParameterError
from plantigrade.models.joint_names import JointMap, identify, split_name
from plantigrade.models.mujoco_warnings import collected_warnings
from plantigrade.printable import listed
from plantigrade.robots.sole import Sole, sole_of
from plantigrade.toml import parse_toml, read_toml

AXIS_WORDS = re.compile(
    r"(?:^|[_\-. ])(?:pitch|roll|yaw|link|body|joint|aa|fe|haa|hfe|x|y|z|\d+)(?=$|[_\-. ])", re.I
)
"""Words for one of several bodies at a joint (``left_hip_roll_link``)."""
LIMBS = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
"""Limbs whose directions are retargeted: from one joint to the next."""
_PROXIMAL = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
"""Joints whose centre is that of the first of their hinges."""
PARTS = (*(f"{j}_{s}" for j in _PROXIMAL for s in SIDES), "pelvis", "torso", "head")
"""Joints and parts of a person that bodies of a robot are."""


@dataclass(frozen=True, kw_only=True)
class RobotSettings:
    """What is taken for a robot."""

    leg_lengths: tuple[float, float] = (0.05, 5.0)
    """Least and greatest length of a leg [m]: a tenth of the smallest humanoid sold, and more than
    the largest one ever built; beyond it the file has another unit, or a slip in it."""


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot that stands in its zero pose, facing any way.

    Attributes:
        model: Its model; the first joint is free.
        joints: Joint of a person (``"hip_l"``, ``"pelvis"``, ``"torso"``) → its body.
        points: Joint of a person → its centre in that body's frame [m].
        standing: The zero pose with the soles on the ground.
        facing: Rotation from axes x forward, y left, z up to those of the model.
        soles: Soles of the feet, by side.
        leg_length: Height of the hips over the ground of straight legs [m].
    """

    model: mujoco.MjModel
    joints: Mapping[str, int]
    points: Mapping[str, Float[Array, " 3"]]
    standing: Float[Array, " nq"]
    facing: Float[Array, "3 3"]
    soles: Mapping[str, Sole]
    leg_length: float

    @classmethod
    def load(
        cls,
        path: str | Path,
        names: Mapping[str, str] | None = None,
        settings: RobotSettings | None = None,
    ) -> "Robot":
        """Return the robot of an MJCF file, or URDF that MuJoCo reads.

        Args:
            path: The file. A root without a free joint gets one.
            names: Joint of a person → body of the robot, for names that say nothing
                (``{"hip_l": "L_leg_1"}``): ``hip``, ``knee``, ``ankle``, ``shoulder``, ``elbow``,
                ``wrist`` with ``_l`` and ``_r``, ``pelvis``, ``torso``, ``head``.
            settings: What is taken for a robot.

        Raises:
            FileError: If MuJoCo cannot read the file, or it holds NaN.
            FitError: If hips, knees or ankles cannot be identified.
            ParameterError: If ``names`` holds an unknown joint or body, a joint is no hinge, or
                legs are too short or too long for any robot.
        """
        path = Path(path).expanduser()
        if not path.is_file():
            raise FileError(path, "there is no such file", remedy="check the name and the folder")
        try:
            with collected_warnings() as said:
                model = _compiled(path)
        except (ValueError, mujoco.FatalError) as error:
            problem = f"MuJoCo cannot read it as a robot: {' '.join(str(error).split())[:200]}"
            remedy = "give MJCF with a body of its own for the robot, and its meshes beside it"
            raise FileError(path, problem, remedy=remedy) from None
        if any("NaN" in each for each in said):
            raise FileError(path, "holds NaN", remedy="write a number in its place")
        return cls.of(model, names, settings)

    @classmethod
    def of(
        cls,
        model: mujoco.MjModel,
        names: Mapping[str, str] | None = None,
        settings: RobotSettings | None = None,
    ) -> "Robot":
        """Return the robot of a compiled model; arguments and errors are those of :meth:`load`."""
        if model.njnt == 0 or model.jnt_type[0] != mujoco.mjtJoint.mjJNT_FREE:
            raise ParameterError("the first joint of the robot must be free; add <freejoint/>")
        if (model.jnt_type[1:] != mujoco.mjtJoint.mjJNT_HINGE).any():
            raise ParameterError("the robot must have hinges alone besides its free root")
        with np.errstate(over="ignore", invalid="ignore"):  # refused below, in a sentence
            robot = cls._measured(model, names or {})
        low, high = (settings or RobotSettings()).leg_lengths
        if not low <= robot.leg_length <= high:  # NaN is not within them
            raise ParameterError(
                f"the legs of the robot are {robot.leg_length:.3g} m long; from {low:g} to "
                f"{high:g} m are allowed, so check the unit of the file"
            )
        return robot

    @classmethod
    def _measured(cls, model: mujoco.MjModel, names: Mapping[str, str]) -> "Robot":
        """Return the robot of a model, whatever its size."""
        data = mujoco.MjData(model)
        data.qpos[:] = model.qpos0
        mujoco.mj_kinematics(model, data)
        first, last = _identified(model, data, names)
        centres = {name: _centre(model, data, body) for name, body in first.items()}
        left = (centres["hip_l"] - centres["hip_r"]) * [1.0, 1.0, 0.0]
        left /= np.linalg.norm(left)
        forward = np.cross(left, [0.0, 0.0, 1.0])
        soles = {
            side: sole_of(
                model,
                data,
                _welded(model, last[f"ankle_{side}"]),
                centres[f"ankle_{side}"],
                forward,
            )
            for side in SIDES
        }
        low = {
            side: data.xpos[sole.body][2] + (data.xmat[sole.body].reshape(3, 3) @ sole.origin)[2]
            for side, sole in soles.items()
        }
        standing = model.qpos0.copy()
        standing[2] -= min(low.values())
        legs = [
            np.linalg.norm(centres[f"hip_{s}"] - centres[f"knee_{s}"])
            + np.linalg.norm(centres[f"knee_{s}"] - centres[f"ankle_{s}"])
            + centres[f"ankle_{s}"][2]
            - low[s]
            for s in SIDES
        ]
        joints = {**last, **{n: b for n, b in first.items() if n.startswith(_PROXIMAL)}}
        points = {
            name: data.xmat[body].reshape(3, 3).T @ (centres[name] - data.xpos[body])
            for name, body in joints.items()
        }
        axes = np.column_stack([forward, left, [0.0, 0.0, 1.0]])
        return cls(model, joints, points, standing, axes, soles, float(np.mean(legs)))

    @property
    def limbs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of joints between which the robot has a limb."""
        pairs = [(f"{a}_{s}", f"{b}_{s}") for a, b in LIMBS for s in SIDES]
        return tuple(pair for pair in pairs if set(pair) <= set(self.joints))

    @property
    def hinges(self) -> tuple[str, ...]:
        """Names of the hinges, in the order of ``qpos[7:]``."""
        return tuple(self.model.joint(k).name for k in range(1, self.model.njnt))

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, without the world."""
        return tuple(self.model.body(k).name for k in range(1, self.model.nbody))


def part_contacts(model: mujoco.MjModel, data: mujoco.MjData):
    """Yield pairs of bodies of a robot that MuJoCo found in contact, with the contact."""
    for contact in data.contact:
        a, b = (int(k) for k in model.geom_bodyid[contact.geom])
        if model.body_weldid[a] and model.body_weldid[b]:
            yield (min(a, b), max(a, b)), contact


def read_names(path: str | Path) -> dict[str, str]:
    """Return the joints of a TOML file: joint of a person → body of a robot."""
    remedy = 'write one line per joint: hip_l = "BODY"'
    found = parse_toml(read_toml(path), path, remedy)
    for name, body in found.items():
        if name not in PARTS or not isinstance(body, str):
            problem = f"{name!r} is no joint of a person with the name of a body"
            raise FileError(path, problem, remedy=f"{remedy}; joints: {', '.join(PARTS)}")
    return found


def _bodies_below(body) -> int:
    return 1 + sum(_bodies_below(child) for child in body.bodies)


def _compiled(path: Path) -> mujoco.MjModel:
    """Return the model of a file, with a free root."""
    spec = mujoco.MjSpec.from_file(str(path))
    roots = [body for body in spec.bodies if body.parent == spec.worldbody]
    free = mujoco.mjtJoint.mjJNT_FREE
    if not any(joint.type == free for root in roots for joint in root.joints):
        (max(roots, key=_bodies_below) if roots else spec.worldbody).add_freejoint()
    return spec.compile()


def _centre(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Float[Array, " 3"]:
    """Return the centre of the first joint of a body, or its origin where it has none [m]."""
    joint = int(model.body_jntadr[body])
    return (data.xpos[body] if joint < 0 else data.xanchor[joint]).copy()


def _welded(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and those that are fixed to it."""
    weld = model.body_weldid
    return [body, *(k for k in np.flatnonzero(weld == weld[body]).tolist() if k != body)]


def _identified(model, data, names) -> tuple[dict[str, int], dict[str, int]]:
    """Return joint of a person → first and last body of the robot that moves at it."""
    bodies = [model.body(k).name for k in range(model.nbody)]
    plain = [re.sub(r"\s+", "_", AXIS_WORDS.sub(" ", name).strip()) for name in bodies]
    wrong = [name for name in names if name not in PARTS]
    if wrong:
        raise ParameterError(f"{wrong[0]!r} is no joint of a person; there are {', '.join(PARTS)}")
    unknown = [body for body in names.values() if body not in bodies]
    if unknown:
        raise ParameterError(f"the robot has no body {unknown[0]!r}; it has {listed(bodies[1:])}")
    kept, groups = [], []  # the first body of each chain of bodies with one plain name, and all
    for k in range(1, model.nbody):
        parent = model.body_parentid[k]
        home = next((g for g in groups if parent in g and plain[g[0]] == plain[k]), None)
        if home is not None and plain[k]:
            home.append(k)
        else:
            kept.append(k)
            groups.append([k])
    index = {body: i for i, group in enumerate(groups) for body in group}
    parents = [index.get(int(model.body_parentid[k]), -1) for k in kept]
    centres = np.array([_centre(model, data, k) for k in kept])
    centres[0] = data.xpos[kept[0]]
    labels = [plain[k] or bodies[k] for k in kept]
    given = {ours: labels[index[bodies.index(theirs)]] for ours, theirs in names.items()}
    try:
        found = identify(labels, parents, centres, given)
    except FitError as error:
        raise FitError(
            "hips, knees and ankles of the robot cannot be identified by name or shape; its "
            f'bodies are {listed(bodies[1:])}. Say which is which: hip_l = "BODY", … ({error})'
        ) from None
    return _by_part(found, groups, labels)


def _by_part(found: JointMap, groups, labels) -> tuple[dict[str, int], dict[str, int]]:
    """Return parts by their first and their last body."""
    kept = dict(found.joints)
    if "thorax" in kept:
        kept["torso"] = kept.pop("thorax")
    else:
        words = [split_name(label)[0] for label in labels]
        torso = next((k for k, word in enumerate(words) if word in ("torso", "chest")), None)
        if torso is not None and torso != kept["pelvis"]:
            kept.setdefault("torso", torso)
    kept = {name: k for name, k in kept.items() if name in PARTS}
    return (
        {name: groups[k][0] for name, k in kept.items()},
        {name: groups[k][-1] for name, k in kept.items()},
    )
