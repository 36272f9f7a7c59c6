r"""Put the motion of another skeleton (ASF/AMC, BVH, DeepMimic, SMPL) on a person.

**Lengths.** Thigh, shank, hip and shoulder width, upper arm, forearm, trunk and foot are those of
the file's skeleton; stature follows from legs and trunk by the usual proportions.

**Directions.** Joint centres determine the direction of bones. How a bone is turned about its own
axis, and how pelvis, thorax, head, hands and feet are turned, comes from the file's bone rotations

.. math:: R_{ours}(t) = R_{file}(t)\, A,

with a constant :math:`A` for every bone. Pelvis and head are upright in the rest pose,
:math:`A = 1`. Thigh and upper arm: :math:`A` swings our bone onto the file's in its rest pose, then
turns it about itself so that the hinge of knee or elbow is the axis about which the file's lower
bone turned in the motion. Foot and toes: :math:`A` makes them flat, pointing along the foot, in the
frames in which the file's foot stands flat; where a file puts the toe base does not matter. Hands:
thumbs point forward in the rest pose unless a thumb points elsewhere.

**Poses.** Inverse kinematics on joint centres and these directions, joint limits hard. Then the
motion is moved down to the ground and the feet are planted
(:mod:`plantigrade.kinematics.planting`).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.errors import FitError
from plantigrade.kinematics.foot_bones import with_bones
from plantigrade.kinematics.ground_level import level
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.result import Fit, filled, human_of
from plantigrade.kinematics.skeleton_source import SkeletonSource
from plantigrade.kinematics.skeleton_targets import SkeletonTargets
from plantigrade.kinematics.sole_paths import SolePaths, sole_paths
from plantigrade.kinematics.sole_rests import contact_metrics, find_rests
from plantigrade.kinematics.stature_estimate import stature_notes
from plantigrade.kinematics.unmeasured_joints import follow_the_legs, note, unmeasured
from plantigrade.models import Human
from plantigrade.models.joint_names import JointMap, identify
from plantigrade.models.person import Person
from plantigrade.motion import Recording
from plantigrade.motion.jumps import jumps
from plantigrade.motion.recording import SkeletonMotion, rate_of
from plantigrade.motion.spikes import spike_note, without_spikes
from plantigrade.motion.turning import quarter_turn_to_face_x, turn
from plantigrade.notes import Info
from plantigrade.printable import listed

# [1] maximum relative difference of given and skeleton stature without rescaling
SCALE_TOLERANCE = 0.06
MAX_PENETRATION = 0.08  # [m] penetration of feet before planting that is reported


def fit_skeleton(
    recording: Recording, person: Person | None = None, *, names: Mapping[str, str] | None = None
) -> Fit:
    """Put the motion of another skeleton on a person with its lengths.

    Args:
        recording: The recording; it must have a skeleton.
        person: Known properties of the person; the recording's metadata supply others. By default
            the height is the skeleton's, to which one that differs by more than 6 % scales the
            file, and the mass is that usual for it.
        names: Our joints → the file's names, for skeletons with uninformative names
            (``{"hip_l": "Bone7"}``).

    Raises:
        FitError: If there is no skeleton, or its hips, knees and ankles cannot be identified.
    """
    notes: list[str] = []
    recording, source, angle, repairs = _source_of(recording, names, notes)
    person = filled(person or Person(), recording.subject)
    recording, source, human, stature = _on_person(recording, source, person, notes)
    rate, way = rate_of(source.time), source.way()
    targets = SkeletonTargets(human, source)
    qpos, rise = level(human, targets.follow(), rate, way=way)
    before = sole_paths(human, qpos)
    rests = find_rests(before, rate, way=way)
    bones: dict[str, float] = {}
    if rests and human.feet == "multi-segment":
        qpos, bones = with_bones(human, source.time, qpos, rests)
    if rests:
        qpos = plant_feet(human, qpos, rate=rate, rests=rests, way=way)
    else:
        notes.append("no foot ever rests on the ground; the feet were left unchanged.")
    assumed = unmeasured(human, targets.seen)
    qpos = follow_the_legs(human, source.time, qpos, targets.seen)
    notes += note(assumed, "no joint of the skeleton")
    _add_ground_notes(notes, rise, before if rests else None, way)
    metrics = {
        **_figures(targets.errors(qpos, rise), rise, human),
        "stances": len(rests),
        **contact_metrics(before, rests, way, "_before"),
        **contact_metrics(sole_paths(human, qpos), rests, way),
        **bones,
        **repairs,
        "skeleton_height_m": stature,
        "height_estimated": person.height is None,
    }
    return Fit(
        human=human,
        time=source.time,
        qpos=qpos,
        recording=recording,
        source_kind="skeleton",
        heading=angle,
        assumed=assumed,
        metrics=metrics,
        warnings=tuple(recording.warnings) + tuple(notes),
    )


def _figures(
    error: Float[Array, "n n_joints"], rise: Float[Array, " n"], human: Human
) -> dict[str, float]:
    """Return figures of joint errors and shift of the ground [m], and lengths of the person."""
    return {
        "joint_rms_mm": 1e3 * root_mean_square(error),
        "joint_error_max_mm": 1e3 * float(error.max()),
        "ground_shift_mm": 1e3 * float(np.median(rise)),
        "ground_slope_mm": 1e3 * float(np.ptp(rise)),
        "height_m": human.height,
        **{f"length_{k}_m": getattr(human.dimensions, k) for k in human.dimensions.names()},
    }


def _source_of(
    recording: Recording, names: Mapping[str, str] | None, notes: list[str]
) -> tuple[Recording, SkeletonSource, float, dict[str, float]]:
    """Return the recording without spikes, facing x, its skeleton, the turn [rad], and figures."""
    skeleton = recording.skeleton
    if skeleton is None:
        raise FitError(f"{recording.source} has no skeleton to retarget")
    if len(skeleton.time) < 2:
        raise FitError(f"{recording.source} has fewer than the two frames that are needed")
    if not (np.isfinite(skeleton.positions).all() and np.isfinite(skeleton.rotations).all()):
        raise FitError(f"{recording.source}: the skeleton has gaps (NaN); fill them first")
    found = _identified(skeleton, names, notes)
    bodily = {i for name, i in found.joints.items() if not name.startswith("thumb")}
    skeleton, found_spikes = without_spikes(skeleton, bodily)
    if found_spikes:
        recording = replace(recording, skeleton=skeleton)
        notes.append(spike_note(found_spikes))
    sudden = jumps(skeleton, sorted(bodily))
    if sudden:
        notes.append(
            f"joints jump between two frames, {len(sudden)} times: "
            f"{listed([str(jump) for jump in sudden], 5)}; the motion is smoothed there, but "
            "check the file."
        )
    source = SkeletonSource(skeleton, found)
    angle = quarter_turn_to_face_x(source.facing())
    if angle:
        recording = turn(recording, angle)
        assert recording.skeleton is not None
        source = SkeletonSource(recording.skeleton, found)
    largest = float(np.rad2deg(sudden[0].angle)) if sudden else 0.0
    repairs = {"joint_jumps": len(sudden), "samples_bridged": len(found_spikes)}
    return recording, source, angle, {**repairs, "joint_jump_max_deg": largest}


def _identified(
    skeleton: SkeletonMotion, names: Mapping[str, str] | None, notes: list[str]
) -> JointMap:
    """Return the joints of a skeleton, and add notes if they were identified by shape."""
    found = identify(skeleton.names, skeleton.parents, skeleton.rest_positions, names)
    if found.swapped:
        notes.append(
            "the joints were identified by shape and the feet point backwards: left and right may "
            "be swapped (give names)."
        )
    if found.by == "shape":
        identified = ", ".join(
            f"{k} = {skeleton.names[i]}" for k, i in sorted(found.joints.items())
        )
        notes.append(
            f"the joint names are unknown; the joints were identified by shape: {identified}."
        )
    return found


def _on_person(
    recording: Recording, source: SkeletonSource, person: Person, notes: list[str]
) -> tuple[Recording, SkeletonSource, Human, float]:
    """Return a person with the lengths of the skeleton, scaled to a given height, and its stature.

    The stature is that of the skeleton in the file [m].
    """
    height, stature = person.height, source.stature()
    if height is not None and abs(height / stature - 1) > SCALE_TOLERANCE:
        notes.append(
            Info(
                f"the skeleton is that of a person of {stature:.2f} m; it was scaled by "
                f"{height / stature:.3f} to the height given, {height:.2f} m."
            )
        )
        skeleton = _scaled(source.skeleton, height / stature)
        recording = replace(recording, skeleton=skeleton)
        source = SkeletonSource(skeleton, source.found)
    elif height is None:
        notes += stature_notes(stature, None, "the skeleton", recording.subject.age)
    height = float(np.clip(stature, 0.5, 2.5) if height is None else height)
    lengths = source.lengths(height, person.sex or "male")
    return recording, source, human_of(person, height, lengths, recording.subject.age), stature


def _add_ground_notes(
    notes: list[str], rise: Float[Array, " n"], soles: SolePaths | None, way: Float[Array, "n 3"]
) -> None:
    """Add notes on shift, slope and motion of the ground, and on soles that were below it."""
    middle = float(np.median(rise))
    if abs(middle) > 0.10:
        notes.append(Info(f"the motion was shifted by {middle:+.2f} m onto the ground."))
    if np.ptp(rise) > 0.02:
        notes.append(
            f"the file's ground slopes by {1e3 * np.ptp(rise):.0f} mm along the path; this was "
            "removed."
        )
    sunk = 0.0 if soles is None else float(soles.penetration.max())
    if sunk > MAX_PENETRATION:
        notes.append(
            f"feet were up to {1e3 * sunk:.0f} mm under the level ground (uneven terrain?); they "
            "were lifted onto it."
        )
    if np.abs(np.ptp(way, axis=0)).max() > 0:
        notes.append(Info("the ground moves under the feet (a treadmill, or walking in place)."))


def _scaled(skeleton: SkeletonMotion, factor: float) -> SkeletonMotion:
    """Return a skeleton with other lengths; its path scales too unless the lengths were assumed."""
    lengths = ("positions", "rest_positions", "ends")
    scaled = {name: getattr(skeleton, name) * factor for name in lengths}
    if skeleton.lengths_assumed:
        kept = (1 - factor) * skeleton.positions[:, :1]
        scaled |= {"positions": scaled["positions"] + kept, "ends": scaled["ends"] + kept}
    return replace(skeleton, **scaled)
