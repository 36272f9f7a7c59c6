"""How much of a difference in knee flexion is the reference's joint centres and its zero.

Knee flexion of two models differs by a constant where their joint centres do. Plug-in Gait stores
the centres of hip, knee and ankle (``FEP``, ``FEO``, ``TIO``); OpenSim's follow from its model and
coordinates. Each takes the place of ours alone; the change of the angle between the lines from hip
to knee and from knee to ankle is its share of the bias. The rest is the zero of the coordinate:
the angle between these lines in the zero pose.
"""

from collections.abc import Mapping
from itertools import permutations, product
from pathlib import Path

import numpy as np

from experiments.stored_angles import on_clock
from experiments.table import Row
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.io import read
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.text import read_text
from plantigrade.kinematics.osim_inverse import take_coordinates
from plantigrade.kinematics.state import body_paths
from plantigrade.motion import Recording

CENTRES = ("hip", "knee", "ankle")
STORED = {"hip": "FEP", "knee": "FEO", "ankle": "TIO"}
"""Joint centre → Plug-in Gait's output, without the side."""
MAX_BYTES = 10**8  # [1] size of a model
COLUMNS = tuple(
    f"knee flexion by {what}, {side}"
    for side in SIDES
    for what in (*(f"their {centre} centre" for centre in CENTRES), "all three", "our zero")
)
"""Quantities of the rows."""

Paths = Mapping[str, Float[Array, "n_frames 3"]]  # joint centre and side → its path [m]


def centre_rows(name: str, trial: Trial, theirs: Paths) -> list[Row]:
    """Return how much more flexed our knee is by each joint centre of a reference [deg].

    The last row of a side is our coordinate less the flexion of the lines between our centres; with
    the row of all three, it is our coordinate less the flexion of the lines of the reference.
    """
    ours, femur = _our_centres(trial)
    rows: list[Row] = []
    for side in SIDES:
        own = [ours[f"{centre}_{side}"] for centre in CENTRES]
        other = [path for c in CENTRES if (path := theirs.get(f"{c}_{side}")) is not None]
        if len(other) < len(CENTRES):
            continue
        seen = np.isfinite(np.concatenate(other, axis=1)).all(axis=1)
        flexion = _flexion(femur[side], *own)
        changed = [[*own[:k], other[k], *own[k + 1 :]] for k in range(len(CENTRES))]
        shares = [flexion - _flexion(femur[side], *three) for three in (*changed, other)]
        coordinate = trial.fit.qpos[:, 7 + trial.fit.human.hinge(f"knee_angle_{side}")]
        shares.append(np.rad2deg(coordinate) - flexion)
        columns = [column for column in COLUMNS if column.endswith(side)]
        rows += [
            Row(name, column, float(share[seen].mean()), "deg")
            for column, share in zip(columns, shares, strict=True)
        ]
    return rows


def plug_in_gait_centres(trial: Trial, recording: Recording) -> Paths:
    """Return the joint centres that Plug-in Gait stored, in the axes of the fit [m].

    Outputs have the axes of the file, so the signed permutation with the nearest knees is taken.
    """
    assert recording.markers is not None
    found: dict[str, np.ndarray] = {}
    for side, centre in product(SIDES, CENTRES):
        stored = recording.outputs.get(side.upper() + STORED[centre])
        if stored is None:
            return {}
        stored = np.where((stored == 0).all(axis=1, keepdims=True), np.nan, stored)
        columns = [on_clock(recording.markers.time, x, trial.fit.time) for x in stored.T]
        found[f"{centre}_{side}"] = np.stack(columns, axis=1)
    knee, _ = _our_centres(trial)
    turns = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        turn = np.zeros((3, 3))
        turn[range(3), order] = signs
        if np.linalg.det(turn) > 0:
            away = found["knee_r"] @ turn.T - knee["knee_r"]
            turns.append((float(np.nanmean(np.linalg.norm(away, axis=1))), turn))
    nearest = min(turns, key=lambda each: each[0])[1]
    return {name: path @ nearest.T for name, path in found.items()}


def opensim_centres(trial: Trial, model: Path, coordinates: Path) -> Paths:
    """Return the joint centres of an OpenSim model in its own motion, axes of the fit [m]."""
    human = OsimHuman.of(read_text(model, MAX_BYTES), model)
    table = read(coordinates).coordinates
    assert table is not None
    poses = human.poses(take_coordinates(human, table).u)
    c, s = np.cos(trial.fit.heading), np.sin(trial.fit.heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    bodies = {"hip": "femur", "knee": "tibia", "ankle": "talus"}
    found = {}
    for side, (centre, body) in product(SIDES, bodies.items()):
        path = body_paths(human, poses, [human.body(f"{body}_{side}")])[0][:, 0] @ turn.T
        columns = [
            np.interp(trial.fit.time, table.time, x, left=np.nan, right=np.nan) for x in path.T
        ]
        found[f"{centre}_{side}"] = np.stack(columns, axis=1)
    return found


def _our_centres(trial: Trial) -> tuple[Paths, dict[str, np.ndarray]]:
    """Return our joint centres [m] and the axes of the thighs over time."""
    human, qpos = trial.fit.human, trial.fit.qpos
    paths, femur = {}, {}
    for side in SIDES:
        bodies = [human.body(f"{body}_{side}") for body in ("femur", "tibia", "foot")]
        origin, axes = body_paths(human, qpos, bodies)
        paths |= {f"{centre}_{side}": origin[:, k] for k, centre in enumerate(CENTRES)}
        femur[side] = axes[:, 0]
    return paths, femur


def _flexion(axes, hip, knee, ankle) -> Float[Array, " n_frames"]:
    """Return the angle between the lines of thigh and shank in the thigh's sagittal plane [deg]."""
    angles = []
    for line in (knee - ankle, hip - knee):
        local = np.einsum("nji,nj->ni", axes, line)
        angles.append(np.arctan2(local[:, 0], local[:, 2]))
    return np.rad2deg(angles[0] - angles[1])
