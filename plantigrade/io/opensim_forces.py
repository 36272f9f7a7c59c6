r"""Ground reactions in OpenSim tables.

Any columns ``NAMEvx NAMEvy NAMEvz`` are a force, ``NAMEpx …`` its point,
``NAMEmx …`` or the same name with *torque* or *moment* instead of *force* its torque about that
point. With force :math:`f` and torque :math:`t` about :math:`p`, the centre of pressure and the
free moment about the vertical are (file axes)

.. math:: c = p + (t_z / f_y,\ 0,\ -t_x / f_y), \quad
    T = t_y - (c_z - p_z) f_x + (c_x - p_x) f_z .

Torques about another point, such as the laboratory's origin, are recognised
(:mod:`plantigrade.io.moment_reference`).
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.io.moment_reference import MomentReference, reference
from plantigrade.motion.plate_baseline import baseline_note, unloaded
from plantigrade.motion.recording import ForcePlate, Table
from plantigrade.notes import Info
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD

MIN_FORCE = 10.0  # [N] vertical; below it there is no centre of pressure
MAX_BASELINE = 50.0  # [N] maximum force on an unloaded plate


@dataclass(frozen=True)
class ForceGroup:
    """Columns of one ground reaction."""

    name: str  #: Common part of the column names
    #: Three columns each of force, point and torque; empty if missing
    columns: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]


def force_groups(names: Sequence[str]) -> list[ForceGroup]:
    """Return the ground reactions among the column names, in the order of the file."""
    have = set(names)
    groups = []
    for name in names:
        if not re.search(r"(?:^|[^A-Za-z]|force|grf)[vV][xX]$", name, re.IGNORECASE):
            continue
        stem, v = name[:-2], name[-2]
        lower = name[-1] == "x"
        xyz = "xyz" if lower else "XYZ"

        def triple(stem: str, letters: str, xyz: str = xyz) -> tuple[str, ...]:
            """Return the three columns ``stem + letters + axis`` if all exist."""
            columns = tuple(f"{stem}{letters}{x}" for x in xyz)
            return columns if have.issuperset(columns) else ()

        force = triple(stem, v)
        if not force:
            continue
        point = triple(stem, "p") or triple(stem, "P")
        torque: tuple[str, ...] = triple(stem, "m") or triple(stem, "M") or triple(stem, "t")
        for word in ("torque", "moment"):
            other = stem.replace("force", word).replace("Force", word.title())
            if other != stem and not torque:
                torque = triple(other, "") or triple(other, "m") or triple(other, "t")
        groups.append(ForceGroup(stem.rstrip("_. ") or "force", (force, point, torque)))
    return groups


def side_of(name: str) -> str | None:
    """Return ``"r"`` or ``"l"`` if the name of a plate states the foot, else None.

    Example:
        >>> side_of("ground_force_r"), side_of("calcn_l_force"), side_of("1_ground_force")
        ('r', 'l', None)
    """
    found = re.search(r"(?:^|[_. ])(r|l|right|left)(?:$|[_. ])", name, re.IGNORECASE)
    return found[1][0].lower() if found else None


def plates_of(
    table: Table, groups: Sequence[ForceGroup], warnings: list[str]
) -> tuple[ForcePlate, ...]:
    """Return ground reactions at their centres of pressure, in our axes."""
    measured = [_samples(table, group, warnings) for group in groups]
    loaded = [
        (each[0][:, 1] >= MAX_BASELINE) & np.isfinite(each[1]).all(axis=1) for each in measured
    ]
    common = None  # all torques of a file have the same kind of reference point
    if measured:
        f, p, t = (np.concatenate(each) for each in zip(*measured, strict=True))
        common = reference(f, p, t, np.concatenate(loaded), 1, fixed=False)
    result = []
    for group, (f, p, t), on in zip(groups, measured, loaded, strict=True):
        about = common or reference(f, p, t, on, 1)
        if about is not None:
            t = about.about(f, p, t)
            if about is not common:
                warnings.append(_note(about, f"{group.name}: "))
        result.append(_plate(table, group, f, p, t))
    if common is not None:
        warnings.append(_note(common))
    return tuple(result)


def _note(about: MomentReference, where: str = "") -> str:
    return Info(
        f"{where}the torques are about {about}, not about the points of application; they were "
        "converted"
    )


def _samples(
    table: Table, group: ForceGroup, warnings: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return force on the body, point and torque in the file's axes [N, m, N m], (n, 3) each."""
    n = len(table.time)

    def columns(names: tuple[str, ...], missing: float) -> np.ndarray:
        if not names:
            return np.full((n, 3), missing)
        return np.stack([table[name] for name in names], axis=1)

    f, p, t = (
        columns(names, missing)
        for names, missing in zip(group.columns, (0.0, np.nan, 0.0), strict=True)
    )
    size = np.nan_to_num(np.abs(f)).mean(axis=0)
    if size.max() > 0 and size[1] < 0.8 * size.max():
        warnings.append(
            f"{group.name}: the largest force is along {'xyz'[int(size.argmax())]}, not y; OpenSim "
            "files have y up"
        )
    loaded = np.abs(f[:, 1]) >= MIN_FORCE
    heavy = np.abs(f[:, 1]) >= MAX_BASELINE  # certainly loaded
    if heavy.any() and np.median(f[heavy, 1]) < 0:
        warnings.append(f"{group.name}: forces point down; they were reversed to act on the body")
        f, t = -f, -t
    empty = unloaded(table.time, f[:, 1])
    if empty is not None:  # the points of the file stay: of an unloaded plate they mean nothing
        warnings.append(baseline_note(group.name, float(np.median(f[empty, 1]))))
        f = f - np.median(f[empty], axis=0)
    loaded &= f[:, 1] >= MIN_FORCE
    far = np.abs(p[loaded & np.isfinite(p).all(axis=1)])
    if far.size and np.median(far.max(axis=1)) > 20.0:
        warnings.append(f"{group.name}: points are given in mm; they were read so, torques as N mm")
        p, t = p / 1000, t / 1000
    if not group.columns[1]:
        warnings.append(f"{group.name}: the file gives no point of application")
    elif loaded.any() and not np.any(p[loaded]) and not np.any(t[loaded]):
        warnings.append(
            f"{group.name}: point of application and torque are all zero, taken as unknown"
        )
        p = np.full_like(p, np.nan)
    return f, p, np.where(np.isfinite(t), t, 0.0)


def _plate(
    table: Table, group: ForceGroup, f: np.ndarray, p: np.ndarray, t: np.ndarray
) -> ForcePlate:
    """Return one ground reaction at its centre of pressure, in our axes."""
    n = len(table.time)
    loaded = f[:, 1] >= MIN_FORCE
    vertical = np.where(loaded, f[:, 1], np.nan)
    d_x, d_z = t[:, 2] / vertical, -t[:, 0] / vertical  # from p to the centre of pressure [m]
    cop = p + np.stack([d_x, np.zeros(n), d_z], axis=1)
    free = t[:, 1] - (np.nan_to_num(d_z) * f[:, 0] - np.nan_to_num(d_x) * f[:, 2])
    cop[~loaded] = np.nan
    return ForcePlate(
        name=group.name,
        time=table.time,
        force=f @ OPENSIM_TO_WORLD.T,
        cop=cop @ OPENSIM_TO_WORLD.T,
        free_moment=np.where(np.isfinite(free), free, 0.0),
        side=side_of(group.name),
    )


def plates_table(plates: Sequence[ForcePlate]) -> Table:
    """Return plates as OpenSim's columns, at the times of the first one."""
    if not plates:
        raise ParameterError("there are no plates to write")
    time = plates[0].time
    names: list[str] = []
    columns: list[np.ndarray] = []
    sides = [plate.side for plate in plates]
    for n, plate in enumerate(plates, start=1):
        known = plate.side if plate.side and sides.count(plate.side) == 1 else str(n)
        loaded = np.all(np.isfinite(plate.cop), axis=1)
        force = np.nan_to_num(plate.force) @ OPENSIM_TO_WORLD
        cop = np.where(loaded[:, None], plate.cop, 0.0) @ OPENSIM_TO_WORLD
        zero = np.zeros(len(plate.time))
        signals = [*force.T, *cop.T, zero, np.nan_to_num(plate.free_moment), zero]
        if len(plate.time) != len(time) or not np.allclose(plate.time, time):
            signals = [np.interp(time, plate.time, s, left=0, right=0) for s in signals]
        names += [f"ground_force_{known}_{q}{x}" for q in "vp" for x in "xyz"]
        names += [f"ground_torque_{known}_{x}" for x in "xyz"]
        columns += signals
    return Table(tuple(names), time, np.stack(columns, axis=1))
