"""Spikes: single samples far off an otherwise smooth curve, detected and bridged.

A joint that turns by a right angle for one frame, or a root that is displaced for one frame, is an
error of the file. Without these samples the curve is smooth; without the samples of a kick or an
impact it bends as before, which tells fast motion from a spike.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.recording import SkeletonMotion, Table
from plantigrade.notes import Info
from plantigrade.printable import listed

MAX_FRAMES = 2
"""Longest spike [frames]."""
MIN_ROTATION = np.deg2rad(5.0)  # [rad] smallest spike of an angle
MIN_DISPLACEMENT = 0.02  # [m] smallest spike of a position
MIN_SMOOTHING = 5.0  # Size of a spike over the largest second difference that remains without it
NEIGHBOURS = 4  # Frames before and after a spike in which the curve must be smooth


@dataclass(frozen=True)
class Spike:
    """Consecutive samples of a channel far off its curve."""

    name: str  #: Joint or coordinate
    time: float  #: Time of the first of them [s]
    angle: float = 0.0  #: Size of a spike of an angle [rad]; zero for a position
    distance: float = 0.0  #: Size of a spike of a position [m]; zero for an angle

    def __str__(self) -> str:
        size = f"{np.rad2deg(self.angle):.0f}°" if self.angle else f"{100 * self.distance:.0f} cm"
        return f"{self.name} by {size} at {self.time:.2f} s"


def spikes(values: Float[Array, " n_frames *channels"], least: float) -> list[tuple[slice, float]]:
    """Return the frames and the size of each spike, in the order of the frames.

    Args:
        values: A signal of one or more channels that have their spikes together, without gaps.
        least: The smallest spike to look for, in the unit of the signal.
    """
    x = np.asarray(values, dtype=float).reshape(len(values), -1)
    n = len(x)
    bends = np.zeros(n)
    bends[1:-1] = np.linalg.norm(x[1:-1] - (x[:-2] + x[2:]) / 2, axis=1)
    found: list[tuple[slice, float]] = []
    free = 1  # first frame that may begin a spike
    for f in np.flatnonzero(bends > 0.4 * least):
        for width in range(1, MAX_FRAMES + 1):
            if f < free or f + width >= n:
                continue
            inside = slice(f, f + width)
            part = np.arange(1, width + 1)[:, None] / (width + 1)
            line = (1 - part) * x[f - 1] + part * x[f + width]
            size = float(np.linalg.norm(x[inside] - line, axis=1).min())
            if not size > least:
                continue
            start, stop = max(f - 1 - NEIGHBOURS, 0), min(f + width + 1 + NEIGHBOURS, n)
            around = x[start:stop].copy()
            around[f - start : f - start + width] = line
            left = np.linalg.norm(around[1:-1] - (around[:-2] + around[2:]) / 2, axis=1)
            if left.max() < size / MIN_SMOOTHING:
                found.append((inside, size))
                free = inside.stop + 1
                break
    return found


def bridged(
    values: Float[Array, " n_frames *channels"], at: slice
) -> Float[Array, " n_inside *channels"]:
    """Return the samples of a spike as the straight line across it."""
    width = at.stop - at.start
    part = np.arange(1, width + 1).reshape(-1, *np.ones(values.ndim - 1, int)) / (width + 1)
    return (1 - part) * values[at.start - 1] + part * values[at.stop]


def spike_note(found: Sequence[Spike]) -> str:
    """Return the note that lists the spikes."""
    return Info(
        "single samples far off the curve were taken for errors of the file and interpolated: "
        f"{listed([str(spike) for spike in found], 4)}."
    )


def without_spikes(
    skeleton: SkeletonMotion, joints: Iterable[int]
) -> tuple[SkeletonMotion, list[Spike]]:
    """Return a skeleton's motion with its spikes bridged, and what these were, the largest first.

    Each joint is examined by itself: its rotation relative to the bone above, and its position in
    that bone's frame; the root in world axes.

    Args:
        skeleton: The motion, without gaps.
        joints: Joints to examine; those above them are examined too.
    """
    above, own = skeleton.parents, range(len(skeleton.names))
    examined = set(joints)
    for j in reversed(own):  # children come after parents
        if j in examined and above[j] >= 0:
            examined.add(above[j])
    turned, placed = skeleton.rotations.copy(), skeleton.positions.copy()
    tips = np.einsum("njba,njb->nja", skeleton.rotations, skeleton.ends - skeleton.positions)
    for j in own:
        if above[j] >= 0:
            back = np.swapaxes(skeleton.rotations[:, above[j]], 1, 2)
            turned[:, j] = back @ skeleton.rotations[:, j]
            way = skeleton.positions[:, j] - skeleton.positions[:, above[j]]
            placed[:, j] = np.einsum("nij,nj->ni", back, way)
    found = []
    frames = np.zeros(len(skeleton.time), dtype=bool)
    for j in sorted(examined):
        # Matrices that differ by a turn are 2 sqrt 2 sin(angle / 2) apart.
        for at, size in spikes(turned[:, j], 2 * np.sqrt(2) * np.sin(MIN_ROTATION / 2)):
            angle = 2 * np.arcsin(min(size / (2 * np.sqrt(2)), 1.0))
            found.append(Spike(skeleton.names[j], float(skeleton.time[at.start]), angle=angle))
            u, _, v = np.linalg.svd(bridged(turned[:, j], at))
            turned[at, j] = u @ v
            frames[at] = True
        for at, size in spikes(placed[:, j], MIN_DISPLACEMENT):
            found.append(Spike(skeleton.names[j], float(skeleton.time[at.start]), distance=size))
            placed[at, j] = bridged(placed[:, j], at)
            frames[at] = True
    if not found:
        return skeleton, []
    rotations, positions = skeleton.rotations.copy(), skeleton.positions.copy()
    ends = skeleton.ends.copy()
    f = np.flatnonzero(frames)
    for j in own:  # parents come before children
        if above[j] < 0:
            rotations[f, j], positions[f, j] = turned[f, j], placed[f, j]
        else:
            over = rotations[f, above[j]]
            rotations[f, j] = over @ turned[f, j]
            positions[f, j] = positions[f, above[j]] + np.einsum("nij,nj->ni", over, placed[f, j])
        ends[f, j] = positions[f, j] + np.einsum("nij,nj->ni", rotations[f, j], tips[f, j])
    found.sort(key=lambda spike: -max(spike.angle, spike.distance))
    return replace(skeleton, rotations=rotations, positions=positions, ends=ends), found


def table_without_spikes(table: Table, angles: Iterable[int]) -> tuple[Table, list[Spike]]:
    """Return joint coordinates with their spikes bridged, and what these were, the largest first.

    Args:
        table: The coordinates, without gaps and whole turns.
        angles: Which of its columns are angles; the others are positions.
    """
    values, found, turns = table.values.copy(), [], set(angles)
    for k, name in enumerate(table.names):
        smallest = MIN_ROTATION if k in turns else MIN_DISPLACEMENT
        for at, size in spikes(table.values[:, k], smallest):
            values[at, k] = bridged(table.values[:, k], at)
            kind = {"angle": size} if k in turns else {"distance": size}
            found.append(Spike(name, float(table.time[at.start]), **kind))
    found.sort(key=lambda spike: -max(spike.angle, spike.distance))
    return replace(table, values=values), found
