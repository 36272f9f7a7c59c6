"""How a fitted body stands: its pelvis, its lumbar joint, its trunk, its head and its arms.

None of it shows in the marker error: markers sit where they sit, and a body that hunches below
them follows them as well as one that stands.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square, spread
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import body_paths
from plantigrade.models import Human
from plantigrade.models.anatomy import SPINE_PLANE, hip, lumbar
from plantigrade.models.landmarks import BONE_SPREAD, SKIN_SPREAD, Attachment, attachments
from plantigrade.printable import listed
from plantigrade.side_names import without_side
from plantigrade.spatial.conventions import PELVIS, unit_vectors

MAX_FRAMES = 200  # [1] maximum number of evaluated frames, evenly spread
LIMIT_TOLERANCE = np.deg2rad(0.5)
"""Distance from a limit at which a joint counts as being at it [rad]; the low-pass rounds
corners."""
ARM_COORDINATES = ("elbow_flex", "pro_sup", "wrist_flex", "wrist_dev")


def posture_figures(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    standing: Float[Array, "n_standing nq"] | None = None,
) -> dict[str, Any]:
    """Return the figures of posture (flat, unit as suffix).

    * ``pelvis_tilt_plane_mean_deg``: tilt of the plane through the anterior iliac spines and the
      middle of the posterior ones, positive forward, as Plug-in Gait computes it: the first of
      three turns, about an axis of the laboratory. It is
      :data:`~plantigrade.models.anatomy.SPINE_PLANE` minus ``pelvis_tilt``.
    * ``pelvis_plane_lean_mean_deg``: the lean of that plane against the horizontal, which is the
      same in straight walking, and the meaningful one in a turn [Baker2001]_.
    * ``hip_flexion_plane_mean_{side}_deg``: of the thigh against that plane, as Plug-in Gait's:
      ``hip_flexion`` plus :data:`~plantigrade.models.anatomy.SPINE_PLANE`.
    * ``lumbar_behind_hips_mm``: the lumbar joint behind the line of the hips, in the pelvis.
    * What :func:`lean_figures` has; ``trunk_lean_standing_deg``: the trunk in the standing trial.
    * ``arms_at_stop_pct``: the largest share of frames in which a joint of elbow, forearm or
      wrist is at an end of its range.
    """
    d = human.dimensions
    names, values = human.to_coordinates(qpos)
    mean = {n: float(np.rad2deg(values[:, i].mean())) for i, n in enumerate(names)}
    pelvis = leans(human, _few(qpos), "asis_r")[:, 0]
    arms = [c for c in human.coordinates if without_side(c) in ARM_COORDINATES]
    hinges = [human.hinge(c) for c in arms]
    low, high = human.limits[:, hinges]
    arm = qpos[:, 7:][:, hinges]
    stopped = ((arm < low + LIMIT_TOLERANCE) | (arm > high - LIMIT_TOLERANCE)).mean(axis=0)
    figures = {
        "pelvis_tilt_plane_mean_deg": SPINE_PLANE - mean[PELVIS[0]],
        "pelvis_plane_lean_mean_deg": SPINE_PLANE + float(pelvis.mean()),
        **{
            f"hip_flexion_plane_mean_{s}_deg": SPINE_PLANE + mean[f"hip_flexion_{s}"] for s in SIDES
        },
        "lumbar_behind_hips_mm": 1e3 * float(hip(d)[0] - lumbar(d)[0]),
        **lean_figures(human, qpos),
        "arms_at_stop_pct": 100 * float(max(stopped, default=0.0)),
    }
    if standing is not None and len(standing):
        figures["trunk_lean_standing_deg"] = float(leans(human, standing, "c7")[:, 0].mean())
    return figures


def lean_figures(human: Human, qpos: Float[Array, "n_frames nq"]) -> dict[str, float]:
    """Return how trunk and head lean against the vertical (flat, unit as suffix).

    ``trunk_lean_mean_deg``, ``neck_lean_mean_deg``: on average, positive forward;
    ``trunk_sideways_rms_deg``, ``neck_sideways_rms_deg``: to the sides, root mean square.
    """
    figures = {}
    for name, landmark in (("trunk", "c7"), ("neck", "vertex")):
        ahead, left = leans(human, _few(qpos), landmark).T
        figures[f"{name}_lean_mean_deg"] = float(ahead.mean())
        figures[f"{name}_sideways_rms_deg"] = root_mean_square(left)
    return figures


def _few(qpos: Float[Array, "n_frames nq"]) -> Float[Array, "n_few nq"]:
    return qpos[spread(len(qpos), MAX_FRAMES)]


def pelvis_notes(
    human: Human, places: Sequence[Attachment], attached: Mapping[str, str]
) -> list[str]:
    """Return a warning where the markers do not determine the tilt of the pelvis."""
    joint = np.abs(attachments(human)["hip_joint_r"].position)  # does not show the tilt by itself
    known = [
        p
        for p in places
        if p.body == "pelvis"
        and p.spread <= SKIN_SPREAD
        and max(abs(abs(p.position) - joint)) > SKIN_SPREAD
    ]
    if not known:
        moved = [name for name, body in attached.items() if body == "pelvis"]
        unknown = f" (of unknown names, {listed(moved)} move with it)" if moved else ""
        return [
            f"no marker has the name of a landmark of the pelvis{unknown}: its tilt, hip flexion "
            "and the lumbar joint follow from legs and trunk and may be 30° off; name its markers "
            "in a set of your own (--marker-set FILE)."
        ]
    if any(p.position[0] < -0.6 * human.dimensions.pelvis_depth for p in known):
        return [] if any(p.spread <= BONE_SPREAD for p in known) else [_BELT]
    return [
        "no marker shows the back of the pelvis: its tilt, and hip flexion with it, follow from "
        "the legs and may be off by ten degrees; the shape of the curves is unaffected."
    ]


_BELT = (
    "the markers of the pelvis are on a belt, not on the iliac spines: they are assumed to be at "
    "the height of the spines; otherwise pelvis tilt and hip flexion are offset by some degrees."
)


def leans(
    human: Human, qpos: Float[Array, "n_frames nq"], landmark: str
) -> Float[Array, "n_frames 2"]:
    """Return how far the body that carries a landmark leans forward, and to the left [deg].

    Forward is where the pelvis faces.
    """
    body, pelvis = (human.body(attachments(human)[name].body) for name in (landmark, "asis_r"))
    _, axes = body_paths(human, qpos, (body, pelvis))
    up, ahead = axes[:, 0, :, 2], unit_vectors(axes[:, 1, :2, 0])
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    to_front, to_left = ((up[:, :2] * way).sum(axis=1) for way in (ahead, left))
    # A person who lies on the back leans to no side: the whole upward axis counts there.
    both = np.arctan2(to_front, up[:, 2]), np.arcsin(np.clip(to_left, -1.0, 1.0))
    return np.rad2deg(np.stack(both, axis=1))
