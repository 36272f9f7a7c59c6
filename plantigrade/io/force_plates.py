r"""Force plates of a C3D file: from analog channels to the wrench on the body in world axes.

Every plate type is reduced to force :math:`F` and moment :math:`M` at the centre :math:`C` of the
top surface, in plate axes; the rest is common:

.. math:: p = C + \frac{n \times M}{n \cdot F}, \qquad T = n \cdot (M - (p - C) \times F),

with the plate's normal :math:`n`, the centre of pressure :math:`p` and the free moment :math:`T`.

Plate axes follow from the corners, which C3D lists by quadrant of the plate's own x-y plane:
(+, +), (-, +), (-, -), (+, -); z is their cross product, downwards on most plates.

Conventions that differ between files are decided by physics; unusual ones give a warning:

- whether the channels hold the force on the plate or its reaction: a foot pushes down, so the
  force on the body points up;
- the sign of ORIGIN: the vector goes from the transducer to the centre of the surface, so it
  points out of the plate, whatever the file says;
- the unit of the moments where the file gives none: the one with which the centre of pressure lies
  on the plate.

References:
    The C3D File Format, user guide, c3d.org, FORCE_PLATFORM parameters, types 1 to 5.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.io.c3d_file import C3dFile
from plantigrade.motion.plate_baseline import baseline_note, unloaded
from plantigrade.motion.recording import ForcePlate
from plantigrade.spatial.conventions import axes_along

COP_THRESHOLD = 10.0  # [N] minimum vertical force for a centre of pressure

MIN_LOAD = 50.0  # [N] minimum force on a loaded plate
MAX_BASELINE = 30.0  # [N]

FORCE_UNITS = {
    **dict.fromkeys(("n", "newton", "newtons"), 1.0),
    **{"kn": 1e3, "lb": 4.4482216, "lbf": 4.4482216},
}
MOMENT_UNITS = {
    **dict.fromkeys(("nm", "n.m", "n-m", "n*m", "n m", "newton.metre", "newton-meters"), 1.0),
    **dict.fromkeys(("nmm", "n.mm", "n-mm", "n*mm", "n mm", "newton-millimeters"), 1e-3),
    **dict.fromkeys(("ncm", "n.cm", "n-cm"), 1e-2),
    **dict.fromkeys(("knm", "kn.m"), 1e3),
}
_CHANNELS = {1: 6, 2: 6, 3: 8, 4: 6, 5: 8}


@dataclass(frozen=True)
class _Wrench:
    """Force [N] and moment [N m] at the centre of the surface, plate axes, sign as in the file."""

    force: np.ndarray
    moment: np.ndarray


@dataclass(frozen=True)
class _Geometry:
    """Corners (4, 3) and centre (3,) [m], file axes; rotation from plate to file axes."""

    corners: np.ndarray
    centre: np.ndarray
    rotation: np.ndarray
    half_size: np.ndarray


def plates_from_c3d(
    file: C3dFile, length_unit: float, turn: Float[Array, "3 3"]
) -> tuple[list[ForcePlate], list[str]]:
    """Return the plates of a file and warnings about them.

    Args:
        length_unit: The file's length unit [m].
        turn: Rotation from the file's axes to world axes.
    """
    warnings: list[str] = []
    kinds = file.integers("FORCE_PLATFORM", "TYPE").reshape(-1)
    used = file.value("FORCE_PLATFORM", "USED")
    n_plates = len(kinds) if not np.isfinite(used) else int(max(0, min(used, len(kinds))))
    if n_plates == 0 or file.analog.size == 0:
        return [], ([f"{n_plates} force plates without analog samples"] if n_plates else [])
    time = (file.first_frame - 1) / file.rate + np.arange(len(file.analog)) / file.analog_rate
    found: list[tuple[str, _Geometry, _Wrench]] = []
    for i in range(n_plates):
        name = str(i + 1)
        kind = int(kinds[i])
        if kind not in _CHANNELS:
            warnings.append(
                f"force plate {name} has type {kind}; only types 1 to 5 are read; it was omitted"
            )
            continue
        geometry = _geometry(file, i, length_unit)
        channels = _channels(file, i, _CHANNELS[kind])
        if geometry is None or channels is None:
            what = "four corners that span a plate" if geometry is None else "its analog channels"
            warnings.append(f"force plate {name} was left out: the file lacks {what}")
            continue
        up = (turn @ geometry.rotation)[2, 2]
        wrench = _wrench(file, i, kind, channels, geometry, up, length_unit, name, warnings)
        if wrench is not None:
            found.append((name, geometry, wrench))
    signs = _signs([wrench.force @ geometry.rotation.T @ turn.T for _, geometry, wrench in found])
    plates = []
    for (name, geometry, wrench), sign in zip(found, signs, strict=True):
        wrench = _at_zero(wrench, sign * (turn @ geometry.rotation)[2], time, name, warnings)
        plate = _plate(name, geometry, wrench, sign, time, turn)
        plates.append(plate)
        outside = _share_outside(plate, geometry, turn)
        if outside > 0.2:
            warnings.append(
                f"force plate {name}: the centre of pressure lies off the plate in "
                f"{100 * outside:.0f} % of the loaded samples; its corners, ORIGIN or moment unit "
                "do not match its signals"
            )
    return plates, warnings


def plate_axes(corners: Float[Array, "4 3"]) -> Float[Array, "3 3"]:
    """Return the rotation from plate to file axes (columns: the plate's x, y, z).

    Args:
        corners: Corners by quadrant: (+x, +y), (-x, +y), (-x, -y), (+x, -y).
    """
    x = corners[0] + corners[3] - corners[1] - corners[2]
    y = corners[0] + corners[1] - corners[2] - corners[3]
    with np.errstate(all="ignore"):
        return axes_along(x, y)


def plate_corners(file: C3dFile) -> Float[Array, "n_plates 4 3"]:
    """Return the corners of the plates by quadrant, in the file's unit and axes."""
    corners = _by_plate(file, "CORNERS", 2)
    return corners.swapaxes(1, 2) if corners.shape[1:] == (3, 4) else np.empty((0, 4, 3))


def _by_plate(file: C3dFile, name: str, ndim: int) -> np.ndarray:
    """Return a parameter of each plate, an array of ``ndim`` axes; none if it has another shape."""
    values = file.values("FORCE_PLATFORM", name).astype(float)
    values = values[..., None] if values.ndim == ndim else values
    return np.moveaxis(values, -1, 0) if values.ndim == ndim + 1 else np.empty((0,) * (ndim + 1))


def _geometry(file: C3dFile, i: int, unit: float) -> _Geometry | None:
    corners = plate_corners(file)
    if len(corners) <= i:
        return None
    four = corners[i] * unit
    rotation = plate_axes(four)
    across = [four[0] + four[3] - four[1] - four[2], four[0] + four[1] - four[2] - four[3]]
    size = np.linalg.norm(across, axis=1)
    if not np.isfinite(rotation).all() or not (1e-2 < size).all() or not (size < 1e2).all():
        return None
    return _Geometry(four, four.mean(axis=0), rotation, size / 4)


def _channels(file: C3dFile, i: int, count: int) -> np.ndarray | None:
    """Return the channels of a plate, 0-based."""
    table = _by_plate(file, "CHANNEL", 1)
    if len(table) <= i or table.shape[1] < count:
        return None
    channels = table[i, :count] - 1
    inside = ((channels >= 0) & (channels < file.analog.shape[1])).all()
    return channels.astype(int) if inside else None


def _wrench(file, i, kind, channels, geometry, up, length_unit, name, warnings) -> _Wrench | None:
    raw = _without_baseline(file, file.analog[:, channels], name, warnings)
    if not np.isfinite(raw).all():
        warnings.append(f"force plate {name} was left out: some of its samples are not numbers")
        return None
    origin = _by_plate(file, "ORIGIN", 1)
    known = len(origin) > i and origin.shape[1] == 3
    o = origin[i] * length_unit if known else np.zeros(3)
    units = [unit.lower() for unit in file.strings("ANALOG", "UNITS")]
    unit_of = [units[c] if c < len(units) else "" for c in channels]
    newton = FORCE_UNITS.get(unit_of[2], 1.0)
    if kind in (4, 5):
        matrix = _calibration(file, i, raw.shape[1])
        if matrix is None:
            warnings.append(f"force plate {name} was left out: type {kind} without its CAL_MATRIX")
            return None
        raw, newton = raw @ matrix.T, 1.0
        unit_of = [""] * 6
    if kind == 3:
        a, b = abs(o[0]), abs(o[1])
        fx12, fx34, fy14, fy23, fz1, fz2, fz3, fz4 = newton * raw.T
        force = np.stack([fx12 + fx34, fy14 + fy23, fz1 + fz2 + fz3 + fz4], axis=1)
        moment = np.stack(
            [
                b * (fz1 + fz2 - fz3 - fz4),
                a * (-fz1 + fz2 + fz3 - fz4),
                b * (-fx12 + fx34) + a * (fy14 - fy23),
            ],
            axis=1,
        )
        o = np.array([0.0, 0.0, o[2]])
        candidates = [moment]
    elif kind == 1:
        force = newton * raw[:, :3]
        length = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}.get(unit_of[3], length_unit)
        p = np.stack([raw[:, 3] * length, raw[:, 4] * length, np.zeros(len(raw))], axis=1)
        moment = np.cross(p, force)  # the unit does not move this centre of pressure
        moment[:, 2] += _moment_scales(unit_of[5], length_unit)[0] * raw[:, 5]
        candidates = [moment]
        o = np.zeros(3)  # already at the surface
    else:
        force = newton * raw[:, :3]
        candidates = [scale * raw[:, 3:6] for scale in _moment_scales(unit_of[3], length_unit)]
    o = _origin(o, up)
    wrenches = [_Wrench(force, moment - np.cross(o, force)) for moment in candidates]
    return min(wrenches, key=lambda wrench: _miss(wrench, geometry))


def _origin(o: np.ndarray, up: float) -> np.ndarray:
    """Return ORIGIN [m] with the sign that points from the transducer out of the plate.

    The plate's own z in the world, ``up``, is -1 where it points into the ground, as on nearly
    every plate (its corners run clockwise seen from above).
    """
    return -o if o[2] * up < 0 else o


def _moment_scales(unit: str, length_unit: float) -> list[float]:
    known = MOMENT_UNITS.get(unit.replace("·", ".").strip())
    return [known] if known else sorted({length_unit, 1.0})


def _calibration(file: C3dFile, i: int, n_channels: int) -> np.ndarray | None:
    """Return the matrix (6, n_channels) from channels to force [N] and moment."""
    matrix = _by_plate(file, "CAL_MATRIX", 2)
    if len(matrix) <= i or not np.isfinite(matrix[i]).all():
        return None
    one = matrix[i]
    if one.shape == (6, n_channels):
        return one
    return one.T if one.shape == (n_channels, 6) else None


def _without_baseline(file: C3dFile, raw: np.ndarray, name: str, warnings: list) -> np.ndarray:
    """Subtract the mean over the frames of FORCE_PLATFORM:ZERO, where the plate is unloaded."""
    zero = file.integers("FORCE_PLATFORM", "ZERO").reshape(-1)
    if zero.size < 2:
        return raw
    first, last = int(zero[0]), int(zero[1])
    n_frames = len(file.points)
    if first < 1 or last <= first or last > n_frames:
        return raw  # no range given
    per_frame = len(raw) // n_frames
    baseline = raw[(first - 1) * per_frame : last * per_frame]
    level, spread = np.abs(baseline.mean(axis=0)), np.ptp(raw, axis=0)
    if (level > 0.05 * spread)[2:].any() and level[2] > MAX_BASELINE:
        warnings.append(
            f"force plate {name}: FORCE_PLATFORM:ZERO names frames {first} to {last} as unloaded, "
            "but the plate is loaded there; no baseline was subtracted"
        )
        return raw
    return raw - baseline.mean(axis=0)


def _at_zero(wrench: _Wrench, up: np.ndarray, time: np.ndarray, name: str, warnings: list):
    """Return a wrench without the baseline of the unloaded plate.

    ``up`` maps its force to the vertical force on the body.
    """
    empty = unloaded(time, wrench.force @ up)
    if empty is None:
        return wrench
    warnings.append(baseline_note(name, float(np.median(wrench.force[empty] @ up))))
    return _Wrench(
        wrench.force - np.median(wrench.force[empty], axis=0),
        wrench.moment - np.median(wrench.moment[empty], axis=0),
    )


def _signs(forces: list[np.ndarray]) -> list[float]:
    """Return the sign per plate that makes the force act on the body, upwards."""
    signs = []
    for force in forces:
        vertical = force[:, 2]
        loaded = vertical[np.abs(vertical) > MIN_LOAD]
        signs.append(float(np.sign(loaded.sum())) if loaded.size else 0.0)
    known = [sign for sign in signs if sign]
    usual = known[0] if known else -1.0  # C3D's own rule: the force on the plate
    return [sign or usual for sign in signs]


def _plane(wrench: _Wrench) -> np.ndarray:
    """Return the centre of pressure relative to the centre of the surface, plate axes [m]."""
    fz = wrench.force[:, 2]
    with np.errstate(all="ignore"):
        p = np.stack([-wrench.moment[:, 1] / fz, wrench.moment[:, 0] / fz, np.zeros(len(fz))], 1)
    p[np.abs(fz) < COP_THRESHOLD] = np.nan
    return p


def _miss(wrench: _Wrench, geometry: _Geometry) -> float:
    """Return how far the centre of pressure is from lying well inside the plate."""
    p = _plane(wrench)[:, :2] / geometry.half_size
    heavy = np.abs(wrench.force[:, 2]) > MIN_LOAD
    if not heavy.any():
        return 0.0
    reach = np.median(np.abs(p[heavy]).max(axis=1))
    return float(max(reach - 1.0, 0.0) + (1.0 if reach < 0.01 else 0.0))


def _plate(name, geometry, wrench, sign, time, turn) -> ForcePlate:
    p = _plane(wrench)
    free = wrench.moment[:, 2] - (p[:, 0] * wrench.force[:, 1] - p[:, 1] * wrench.force[:, 0])
    to_world = turn @ geometry.rotation
    force = sign * wrench.force @ to_world.T
    up = to_world[2, 2]  # the plate's z in the world: -1 on a level plate with z down
    return ForcePlate(
        name=name,
        time=time,
        force=force,
        cop=(turn @ geometry.centre) + p @ to_world.T,
        free_moment=np.nan_to_num(sign * up * free),
        corners=geometry.corners @ turn.T,
    )


def _share_outside(plate: ForcePlate, geometry: _Geometry, turn: np.ndarray) -> float:
    heavy = plate.force[:, 2] > MIN_LOAD
    if heavy.sum() < 5:
        return 0.0
    local = (plate.cop[heavy] - turn @ geometry.centre) @ (turn @ geometry.rotation)
    return float((np.abs(local[:, :2]) > geometry.half_size + 0.03).any(axis=1).mean())
