"""Joint coordinates in OpenSim tables: which columns, unit of angle, sign of knee flexion."""

import re
from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float

HYPEREXTENSION = np.deg2rad(20)  # no knee hyperextends further [rad]

NO_ANGLE = re.compile(
    r"(_t[xyz]|_beta|_moment|_force|_torque|_power|_activation|_excitation|_length)$"
)
_NO_COORDINATE = re.compile(
    r"(_moment|_force|_torque|_power|_activation|_excitation|_length|_u|_beta)$"
    r"|\.(activation|fiber_length|excitation)$"
)
COORDINATE = re.compile(
    r"(?:pelvis_(?:tilt|list|rotation|tx|ty|tz)"
    r"|(?:lumbar|thorax|neck|torso|trunk)\w*_(?:extension|bending|rotation)|lumbar"
    r"|(?:hip_(?:flexion|adduction|rotation)|knee_(?:angle|adduction|rotation|flexion)"
    r"|ankle_(?:angle|rotation|flexion)|subtalar_angle|mtp\d?_(?:angle|inversion|adduction)"
    r"|(?:heel|cuboid)_(?:angle|inversion|adduction)|arm_(?:flex|add|rot)|elbow_(?:flex|adduction)\w*"
    r"|pro_sup|wrist_(?:flex|dev)|fingers_flex|clavicle_\w+|shoulder_\w+)_[rl])"
)


def knee_sign(angles: Float[Array, "n k"]) -> int:
    """Return 1 if knee flexion is positive in ``angles`` [rad], -1 if it is negative.

    Knees do not hyperextend by more than 20 degrees, so a larger angle is flexion. If neither or
    both signs reach further, the sign of the median decides; a median within 2 degrees of zero
    counts as positive.
    """
    finite = angles[np.isfinite(angles)]
    if not finite.size:
        return 1
    low, high, middle = finite.min(), finite.max(), float(np.median(finite))
    if (high > HYPEREXTENSION) != (low < -HYPEREXTENSION):
        return 1 if high > HYPEREXTENSION else -1
    return -1 if middle < -np.deg2rad(2) else 1


def turn_knees(
    values: np.ndarray, names: Sequence[str], sign: int | None, warnings: list[str]
) -> None:
    """Turn the knees among ``values`` in place so that flexion is positive."""
    knees = [k for k, name in enumerate(names) if re.fullmatch(r"knee_angle(_[rl])?", name)]
    if not knees:
        return
    if sign is None:
        sign = knee_sign(values[:, knees])
    if sign < 0:
        values[:, knees] *= -1
        warnings.append("knee flexion is negative in this file (as in gait2392); it was reversed")


def coordinate_columns(names: Sequence[str], paths: Sequence[str], used: set[str]) -> list[int]:
    """Return the columns that are coordinates; none unless at least one has a known name."""
    keep, known = [], False
    for k, (name, path) in enumerate(zip(names, paths, strict=True)):
        coordinate = "/" in path and path.endswith("/value")
        if name in used or _NO_COORDINATE.search(name) or ("/" in path and not coordinate):
            continue
        known = known or coordinate or COORDINATE.fullmatch(name) is not None
        keep.append(k)
    return keep if known else []


def to_radians(
    values: np.ndarray,
    names: Sequence[str],
    in_degrees: bool | None,
    warnings: list[str],
    only: set[int] | None = None,
) -> None:
    """Scale the angles among ``values`` in place where they are degrees."""
    angles = [
        k
        for k, name in enumerate(names)
        if not NO_ANGLE.search(name) and (only is None or k in only)
    ]
    joints = [k for k in angles if re.match(r"(hip|knee|ankle)_", names[k])]
    peak = float(np.nanmax(np.abs(values[:, joints]), initial=0.0)) if joints else np.nan
    degrees = in_degrees
    if degrees is None:
        knees = [k for k in angles if names[k].startswith("knee_angle")]
        span = np.ptp(np.nan_to_num(values[:, knees]), axis=0).max() if knees else 0.0
        degrees = not (peak <= np.pi and span > 0.3)
        what = "degrees" if degrees else "radians"
        warnings.append(f"the header does not say whether angles are degrees: {what} were assumed")
    elif not degrees and peak > 4.0:
        degrees = True
        warnings.append(
            f"the header says radians, but joints reach {peak:.0f}: they were read as degrees"
        )
    if degrees:
        values[:, angles] *= np.pi / 180
