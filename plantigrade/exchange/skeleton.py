"""The motion of a run as that of a skeleton of bones, for BVH."""

from pathlib import Path

import numpy as np

from plantigrade.exchange.bones import bone_poses, bones_of
from plantigrade.exchange.clock import at_rate
from plantigrade.io.bvh_writer import write_bvh
from plantigrade.kinematics.state import body_paths
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.recording import SkeletonMotion
from plantigrade.record import Run


def write_skeleton(
    run: Run, path: Path, rig: str = "plantigrade", unit: str = "cm", rate: float | None = None
) -> tuple[str, ...]:
    """Write the motion of a run as BVH, y up.

    Args:
        rig: Whose names the bones have, one of :data:`~plantigrade.exchange.bones.RIGS`.
        unit: ``"m"``, ``"cm"`` or ``"mm"``; the file does not say which.
        rate: Frames per second [Hz]; those of the motion if absent.

    Raises:
        ParameterError: If rig, unit or rate is not allowed.
        FileError: If the file cannot be written.
    """
    motion = at_rate(run.record.motion, rate)
    write_bvh(skeleton_motion(run.record.human, motion, rig), path, unit=unit)
    return ()


def skeleton_motion(human: Human, motion: Motion, rig: str = "plantigrade") -> SkeletonMotion:
    """Return the bones of a person in motion.

    In the rest pose the person stands straight with hanging arms and palms that face forward.

    Raises:
        ParameterError: If there is no such rig.
    """
    bones = bones_of(human, rig)
    paths = body_paths(human, motion.qpos, range(1, human.model.nbody))
    positions, rotations = bone_poses(bones, human, *paths)
    return SkeletonMotion(
        names=tuple(bone.name for bone in bones),
        parents=tuple(bone.parent for bone in bones),
        time=motion.time,
        positions=positions,
        rotations=rotations,
        rest_positions=np.array([bone.rest for bone in bones]),
        ends=bone_poses(bones, human, *paths, ends=True)[0],
    )
