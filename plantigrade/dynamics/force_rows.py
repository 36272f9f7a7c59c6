"""Rows of the quadratic program of ground forces: objective and constraints."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from plantigrade.arrays import Array, Bool, Float
from plantigrade.dynamics.required_forces import RequiredForces

TURN_FORCE_SCALE = (
    0.02  # [BW] lateral force of a turn at which the weight of the mean force is halved
)
STRIDE_SPREAD = 0.4  # [s] standard deviation of the averaging filter, about a stride wide
N_GLOBAL = 7  # [1] unknowns of the whole recording
N_HIP_JOINTS = 3  # [1] flexion, adduction and rotation of the hip, first among the leg joints


class SparseRows:
    """Blocks of rows ``A x ~ b`` of a sparse system, collected block by block.

    Args:
        n_columns: Number of unknowns.
    """

    def __init__(self, n_columns: int):
        self.n_columns = n_columns
        self.count = 0
        self._parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self._right: list[np.ndarray] = []
        self.blocks: dict[str, slice] = {}
        self.place: dict[str, np.ndarray] = {}  # frame and foot of each row of a block

    def add(
        self,
        name: str,
        right: np.ndarray,
        *terms: tuple[np.ndarray, np.ndarray],
        place: np.ndarray | None = None,
    ) -> None:
        """Add rows; each term has columns (rows, m), negative for none, and values of this shape.

        ``place`` holds frame and foot of each row (2, rows); by default the frames in order.
        """
        n = len(right)
        self.blocks[name] = slice(self.count, self.count + n)
        self.place[name] = np.stack([np.arange(n), np.zeros(n, int)]) if place is None else place
        rows = self.count + np.arange(n)
        for columns, values in terms if n else ():
            columns = columns.reshape(n, -1)
            values = np.broadcast_to(values.reshape(len(values), -1), columns.shape)
            keep = columns >= 0
            at = np.broadcast_to(rows[:, None], columns.shape)
            self._parts.append((at[keep], columns[keep], values[keep]))
        self._right.append(np.asarray(right, dtype=float))
        self.count += n

    def system(self) -> tuple[Any, np.ndarray]:
        """Return matrix (SciPy, by rows) and right-hand side."""
        rows, columns, values = (np.concatenate(p) for p in zip(*self._parts, strict=True))
        matrix = sp.coo_matrix((values, (rows, columns)), shape=(self.count, self.n_columns))
        return matrix.tocsr(), np.concatenate(self._right)


@dataclass(frozen=True)
class ForceLayout:
    """Order of the unknowns.

    Each frame, plus one before and one after, has six unknowns of the motion's noise, then six per
    support in contact. The last unknowns are the shift of the centre of mass and, for each foot,
    the offset of its centre of pressure forward and to the left of the mean path.
    """

    start: np.ndarray  #: First unknown of a foot in a frame (n, k); -1 where it has no contact
    noise: np.ndarray  #: First unknown of the noise (n + 2,)
    size: int  #: Number of unknowns

    @classmethod
    def of(cls, contact: Bool[Array, "n k"]) -> "ForceLayout":
        """Return the layout for the frames in which each foot is in contact."""
        sizes = np.concatenate([[6], 6 + 6 * contact.sum(axis=1), [6]])
        noise = np.cumsum(sizes) - sizes
        start = np.where(contact, noise[1:-1, None] + 6 * np.cumsum(contact, axis=1), -1)
        return cls(start, noise, int(sizes.sum()) + N_GLOBAL)

    @property
    def shift(self) -> np.ndarray:
        """Return the three unknowns of the shift of the centre of mass."""
        return self.size - N_GLOBAL + np.arange(3)

    def offset(self, i: int) -> np.ndarray:
        """Return the offsets of both feet from their paths, 0 forward or 1 to the left."""
        return self.size - 4 + i + 2 * np.arange(2)

    @property
    def held(self) -> np.ndarray:
        """Return the frames with a loaded support other than the feet (n,)."""
        return np.asarray((self.start[:, 2:] >= 0).any(axis=1))

    def columns(self, i: int) -> np.ndarray:
        """Return unknown ``i`` (0 to 5) of every foot and frame, (n, k); -1 for none."""
        return np.where(self.start >= 0, self.start + i, -1)


@dataclass(frozen=True)
class PathPrior:
    """Mean path of the centre of pressure, lateral force and load transfer in walking."""

    #: Centre of pressure from the base in the support's heading, forward and left [m]; NaN if
    #: unknown
    mean: Float[Array, "n k 2"]
    spread: Float[Array, "n k 2"]  #: Standard deviation [m]
    side: Float[Array, "n k"]  #: Force to the left in straight walking [BW]; NaN if unknown
    forward: Float[Array, "n k 2"]  #: Horizontal unit vectors of the walking direction
    #: Mean share of each foot in the load of both in double support [1]; NaN elsewhere
    share: Float[Array, "n 2"]


def objective(
    needs: RequiredForces, layout: ForceLayout, path: PathPrior, *, effort: bool
) -> SparseRows:
    """Return the rows of the objective; their names select their scales.

    Args:
        path: Mean path of the centre of pressure.
        effort: Whether to minimise joint moments relative to strength while two supports share the
            load.
    """
    rows = SparseRows(layout.size)
    dt = needs.time[1] - needs.time[0]
    _net_wrench(rows, needs, layout, dt)
    shift = layout.shift
    rows.add("shift", np.zeros(3), (shift[:, None], np.ones((3, 1))))
    for i, name in enumerate(("offset_x", "offset_y")):
        rows.add(name, np.zeros(2), (layout.offset(i)[:, None], np.ones((2, 1))))
    held = layout.held  # a seat also carries the thighs, by an unknown load
    shared = (layout.start >= 0).sum(axis=1) > 1  # load sharing undetermined by the motion
    columns = np.stack([layout.columns(i) for i in range(6)], axis=-1)  # (n, k, 6)
    for k in (0, 1):  # d/dt of the joint moments
        own = columns[:, k]
        for j in range(needs.joints.shape[2]):
            rate = np.diff(needs.joints[:, k, j]) / dt
            before, after = needs.arms[:-1, k, j] / dt, needs.arms[1:, k, j] / dt
            some = (own[:-1, 0] >= 0) | (own[1:, 0] >= 0)
            if j < N_HIP_JOINTS:
                some &= ~(held[:-1] | held[1:])
            rows.add(
                f"rate{k}{j}",
                rate[some],
                (own[:-1][some], -before[some]),
                (own[1:][some], after[some]),
                place=np.stack([np.flatnonzero(some), np.full(int(some.sum()), k)]),
            )
        for j in range(needs.joints.shape[2]) if effort else ():
            strong = needs.strength[k, j]
            some = shared & (own[:, 0] >= 0)
            if j < N_HIP_JOINTS:
                some &= ~held
            joint, arm = needs.joints[some, k, j] / strong, needs.arms[some, k, j] / strong
            frames = np.flatnonzero(some)
            place = np.stack([frames, np.full(len(frames), k)])
            rows.add(f"effort{k}{j}", joint, (own[some], arm), place=place)
    for i in range(6):  # second differences, with zero load out of contact
        own = columns[:, :, i]
        trio = np.stack([own[:-2], own[1:-1], own[2:]], axis=-1).reshape(-1, 3)
        some = (trio >= 0).any(axis=1)
        values = np.tile([[1.0, -2.0, 1.0]], (int(some.sum()), 1)) / dt**2
        place = np.stack(np.divmod(np.flatnonzero(some), columns.shape[1]))
        rows.add(f"bend{i}", np.zeros(int(some.sum())), (trio[some], values), place=place)
    _path(rows, needs, layout, path)
    _side(rows, needs, layout, path)
    _share(rows, layout, path)
    return rows


def _net_wrench(rows: SparseRows, needs: RequiredForces, layout: ForceLayout, dt: float) -> None:
    n = len(needs.time)
    ones = np.ones(needs.base.shape[:2])
    trio = np.stack([layout.noise[:-2], layout.noise[1:-1], layout.noise[2:]], axis=1)
    bend = np.array([[-1.0, 2.0, -1.0]]) / dt**2
    for i, axis in enumerate("xyz"):
        rows.add(f"force_{axis}", needs.force[:, i], (layout.columns(i), ones), (trio + i, bend))
    arm = needs.base - needs.com[:, None]
    held = layout.held  # loads of backrest, arms and thighs bias the centre of mass
    for i, axis in enumerate("xyz"):
        a, b = (i + 1) % 3, (i + 2) % 3  # (r x F)_i = r_a F_b - r_b F_a
        d_a, d_b = (np.where(held, -1, layout.shift[i])[:, None] for i in (a, b))
        rows.add(
            f"moment_{axis}",
            needs.moment[:, i],
            (layout.columns(b), arm[..., a]),
            (layout.columns(a), -arm[..., b]),
            (layout.columns(3 + i), ones),
            (d_a, -needs.force[:, b, None]),
            (d_b, needs.force[:, a, None]),
            (trio + 3 + i, bend),
        )
    for i in range(6):
        rows.add(f"noise{i}", np.zeros(n + 2), (layout.noise[:, None] + i, np.ones((n + 2, 1))))


def _path(rows: SparseRows, needs: RequiredForces, layout: ForceLayout, path: PathPrior) -> None:
    """Add free moments and the path of the centre of pressure."""
    here = layout.start >= 0
    c = [layout.columns(i)[here][:, None] for i in range(6)]
    one = np.ones((int(here.sum()), 1))
    rows.add("free", np.zeros(len(one)), (c[5], one), place=np.stack(np.nonzero(here)))
    held = here.copy()
    held[:, :2] = False
    for i in (0, 1) if held.any() else ():
        shear = layout.columns(i)[held][:, None], np.ones((int(held.sum()), 1))
        rows.add(f"shear{i}", np.zeros(len(shear[1])), shear, place=np.stack(np.nonzero(held)))
    usual = _usual_load(needs, layout)
    for axis, i, turn in (("x", 0, (0.0, -1.0)), ("y", 1, (1.0, 0.0))):
        some = here & np.isfinite(path.mean[..., i])
        if not some.any():
            continue
        place = np.stack(np.nonzero(some))
        c = [layout.columns(j)[some][:, None] for j in range(6)]
        hx, hy = needs.heading[some].T[..., None]
        mean, spread = path.mean[some][:, i, None], path.spread[some][:, i, None]
        # moment about the left axis is -x F_z, about the forward axis y F_z
        about_x, about_y = turn[0] * hx - turn[1] * hy, turn[0] * hy + turn[1] * hx
        offset = np.append(layout.offset(i), np.full(here.shape[1] - 2, -1))[place[1]][:, None]
        rows.add(
            f"path_{axis}",
            np.zeros(len(mean)),
            (c[3], about_x / spread),
            (c[4], about_y / spread),
            (c[2], -mean / spread),
            (offset, -usual[some][:, None] / spread),  # multiplied by the load, which is unknown
            place=place,
        )


def _side(rows: SparseRows, needs: RequiredForces, layout: ForceLayout, path: PathPrior) -> None:
    """Add lateral forces: those of straight walking plus the mean over a stride for turns.

    The distribution of the latter over the feet is unknown and reduces the row's weight.
    """
    from scipy.ndimage import gaussian_filter1d

    here = (layout.start >= 0) & np.isfinite(path.side)
    if not here.any():
        return
    dt = needs.time[1] - needs.time[0]
    turn = gaussian_filter1d(needs.force[:, :2], STRIDE_SPREAD / dt, axis=0, mode="nearest")
    left = np.stack([-path.forward[..., 1], path.forward[..., 0]], axis=-1)
    pull = (left * turn[:, None]).sum(axis=-1)
    mean = path.side + pull * _usual_load(needs, layout)
    width = np.hypot(1.0, pull / TURN_FORCE_SCALE)[here]
    c = [layout.columns(i)[here][:, None] for i in (0, 1)]
    lx, ly = left[here].T[..., None]
    x, y, place = lx / width[:, None], ly / width[:, None], np.stack(np.nonzero(here))
    rows.add("side", mean[here] / width, (c[0], x), (c[1], y), place=place)


def _share(rows: SparseRows, layout: ForceLayout, path: PathPrior) -> None:
    """Add the deviation of the load of each foot from its mean share in double support."""
    some = np.isfinite(path.share).all(axis=1) & (layout.start[:, :2] >= 0).all(axis=1)
    if not some.any():
        return
    right, left = (layout.columns(2)[some, k, None] for k in (0, 1))
    share = path.share[some, :, None]
    frames = np.flatnonzero(some)
    place = np.stack([frames, np.zeros(len(frames), int)])
    rows.add(
        "share", np.zeros(len(frames)), (right, share[:, 1]), (left, -share[:, 0]), place=place
    )


def _usual_load(needs: RequiredForces, layout: ForceLayout) -> np.ndarray:
    """Return the load of each support for equal shares of those in contact (n, k) [BW]."""
    contact = layout.start >= 0
    return contact * np.maximum(needs.force[:, 2:], 0.0) / np.maximum(contact.sum(1), 1)[:, None]


def limits(
    needs: RequiredForces,
    layout: ForceLayout,
    free: Bool[Array, "n k"],
    ramp: Float[Array, "n k"],
    friction: float,
    twist: float,
) -> SparseRows:
    """Return the inequalities ``G x <= h`` of the feet and frames that are free.

    Args:
        needs: Required forces.
        free: Feet and frames with unknown wrench.
        ramp: Maximum load shortly after landing and before take-off [BW]; infinite for no limit.
        friction: Coefficient of friction along each axis.
        twist: Maximum free moment per vertical force [m].
    """
    rows = SparseRows(layout.size)
    c = [layout.columns(i)[free][:, None] for i in range(6)]
    one = np.ones((int(free.sum()), 1))
    zero = np.zeros(len(one))
    rows.add("pull", zero, (c[2], -one))
    for i in (0, 1):
        for way in (1.0, -1.0):
            rows.add(f"slip{i}{way}", zero, (c[i], way * one), (c[2], -friction * one))
    for way in (1.0, -1.0):
        rows.add(f"twist{way}", zero, (c[5], way * one), (c[2], -twist * one))
    hx, hy = needs.heading[free].T[..., None]
    back, front, right, left = needs.sole[free].T[..., None]
    rows.add("front", zero, (c[3], hy), (c[4], -hx), (c[2], -front))
    rows.add("back", zero, (c[3], -hy), (c[4], hx), (c[2], back))
    rows.add("left", zero, (c[3], hx), (c[4], hy), (c[2], -left))
    rows.add("right", zero, (c[3], -hx), (c[4], -hy), (c[2], right))
    max_load = ramp[free]
    some = np.isfinite(max_load)
    rows.add("ramp", max_load[some], (c[2][some], one[some]))
    return rows
