"""Samples that leap away from a smooth curve and back: found, and bridged.

A joint that turns by a right angle for one frame, or a root that is elsewhere for one, is a fault
of the file. It is told from fast motion by what is left when the samples in question are taken out:
of a spike a smooth curve, of a kick or an impact the same bend as before.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.recording import SkeletonMotion, Table
from plantigrade.notes import Info

LONGEST = 2
"""Frames that a spike takes at most."""

LEAST_TURN = np.deg2rad(5.0)
"""A smaller leap of an angle is left alone [rad]."""

LEAST_WAY = 0.02
"""A smaller leap of a position is left alone [m]."""

SMOOTHER = 5.0
"""Without the spike the curve bends by so many times less than the spike leaps."""

AROUND = 4
"""Frames before and after in which it must be smooth."""

LISTED = 4
"""Spikes that a note names one by one."""


@dataclass(frozen=True)
class Spike:
    """Samples of a channel that leap away and back.

    Attributes:
        name: Joint or coordinate.
        time: Time of the first of them [s].
        angle: How far it leaps [rad]; zero for a position.
        way: The same of a position [m]; zero for an angle.
    """

    name: str
    time: float
    angle: float = 0.0
    way: float = 0.0

    def __str__(self) -> str:
        """Return it for a message."""
        leap = f"{np.rad2deg(self.angle):.0f}°" if self.angle else f"{100 * self.way:.0f} cm"
        return f"{self.name} by {leap} at {self.time:.2f} s"


def spikes(values: Float[Array, " n_frames *channels"], least: float) -> list[tuple[slice, float]]:
    """Return the frames of each spike and how far it leaps, in the order of the frames.

    Args:
        values: A signal of one or more channels that leap together, without gaps.
        least: The smallest leap to look for, in its unit.
    """
    x = np.asarray(values, dtype=float).reshape(len(values), -1)
    n = len(x)
    bends = np.zeros(n)
    bends[1:-1] = np.linalg.norm(x[1:-1] - (x[:-2] + x[2:]) / 2, axis=1)
    found: list[tuple[slice, float]] = []
    free = 1  # first frame that may begin a spike
    for f in np.flatnonzero(bends > 0.4 * least):
        for width in range(1, LONGEST + 1):
            if f < free or f + width >= n:
                continue
            inside = slice(f, f + width)
            part = np.arange(1, width + 1)[:, None] / (width + 1)
            line = (1 - part) * x[f - 1] + part * x[f + width]
            leap = float(np.linalg.norm(x[inside] - line, axis=1).min())
            if not leap > least:
                continue
            start, stop = max(f - 1 - AROUND, 0), min(f + width + 1 + AROUND, n)
            around = x[start:stop].copy()
            around[f - start : f - start + width] = line
            left = np.linalg.norm(around[1:-1] - (around[:-2] + around[2:]) / 2, axis=1)
            if left.max() < leap / SMOOTHER:
                found.append((inside, leap))
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
    """Return the sentence that says what was bridged."""
    more = f" and {len(found) - LISTED} more" if len(found) > LISTED else ""
    return Info(
        "single samples leap away and back; they were taken for faults of the file and bridged: "
        f"{', '.join(str(spike) for spike in found[:LISTED])}{more}."
    )


def without_spikes(
    skeleton: SkeletonMotion, joints: Iterable[int]
) -> tuple[SkeletonMotion, list[Spike]]:
    """Return a skeleton's motion with its spikes bridged, and what these were, the largest first.

    Each joint is looked at by itself: how its bone is turned against the one above, and where it
    lies in that bone's frame; the root in the world.

    Args:
        skeleton: The motion, without gaps.
        joints: Which of its joints to look at, with those above them.
    """
    above, own = skeleton.parents, range(len(skeleton.names))
    looked = set(joints)
    for j in reversed(own):  # children come after parents
        if j in looked and above[j] >= 0:
            looked.add(above[j])
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
    for j in sorted(looked):
        # Matrices that differ by a turn are 2 sqrt 2 sin(angle / 2) apart.
        for at, leap in spikes(turned[:, j], 2 * np.sqrt(2) * np.sin(LEAST_TURN / 2)):
            angle = 2 * np.arcsin(min(leap / (2 * np.sqrt(2)), 1.0))
            found.append(Spike(skeleton.names[j], float(skeleton.time[at.start]), angle=angle))
            u, _, v = np.linalg.svd(bridged(turned[:, j], at))
            turned[at, j] = u @ v
            frames[at] = True
        for at, leap in spikes(placed[:, j], LEAST_WAY):
            found.append(Spike(skeleton.names[j], float(skeleton.time[at.start]), way=leap))
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
    found.sort(key=lambda spike: -max(spike.angle, spike.way))
    return replace(skeleton, rotations=rotations, positions=positions, ends=ends), found


def table_without_spikes(table: Table, angles: Iterable[int]) -> tuple[Table, list[Spike]]:
    """Return joint coordinates with their spikes bridged, and what these were, the largest first.

    Args:
        table: The coordinates, without gaps and whole turns.
        angles: Which of its columns are angles; the others are positions.
    """
    values, found, turns = table.values.copy(), [], set(angles)
    for k, name in enumerate(table.names):
        for at, leap in spikes(table.values[:, k], LEAST_TURN if k in turns else LEAST_WAY):
            values[at, k] = bridged(table.values[:, k], at)
            size = {"angle": leap} if k in turns else {"way": leap}
            found.append(Spike(name, float(table.time[at.start]), **size))
    found.sort(key=lambda spike: -max(spike.angle, spike.way))
    return replace(table, values=values), found
