"""Program of ground forces over a long recording, in overlapping windows.

A frame affects the forces of about one stride around it. The shift of the centre of mass and the
offsets of the feet's paths are global; every window estimates them anew. Memory is that of one
window, whatever the length of the recording.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.force_bands import Spread
from plantigrade.dynamics.force_program import ForceProgram
from plantigrade.dynamics.force_scales import ForceScales
from plantigrade.dynamics.loading import Support
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.required_forces import RequiredForces
from plantigrade.models import Human

MAX_WINDOW_FRAMES = 2000  # Maximum number of frames per window [1]; 40 s at 50 Hz, about 100 MB
WINDOW_OVERLAP_S = 1.5
"""Overlap of a window with each neighbour [s]; more than a stride, because the ends of a window are
less certain."""


@dataclass(frozen=True)
class ForceSolution:
    """Optimum of the program over a recording, in axes of the ground."""

    wrench: Float[Array, "n k 6"]  #: The estimate [BW, BW m]
    spread: Spread  #: Its standard deviations
    shift: Float[Array, " 3"]  #: Shift of the centre of mass, mean over windows [m]
    noise: float  #: Noise of the motion over the assumed noise, mean over windows
    residual_force: float  #: Root mean square of the net force in excess of the noise [BW]
    residual_moment: float  #: The same of the pitch and roll moment [BW m]


def solve_in_windows(
    human: Human,
    needs: RequiredForces,
    contacts: tuple[ContactInterval, ...],
    supports: tuple[Support, ...],
    data: FootForces | None,
    scales: ForceScales,
) -> ForceSolution:
    """Return the ground forces that a motion requires.

    Raises:
        SolverError: If the program of a window cannot be solved.
    """
    margin = int(np.ceil(WINDOW_OVERLAP_S / (needs.time[1] - needs.time[0])))
    parts = []
    for window, kept in windows(len(needs.time), margin):
        here = needs.frames(window)
        first = here.time[0] if window.start else -np.inf
        last = here.time[-1] if window.stop < len(needs.time) else np.inf
        own = tuple(c.within(first, last) for c in contacts if c.stop > first and c.start < last)
        measured = None if data is None else data.frames(window)
        program = ForceProgram(human, here, own, supports, measured, scales)
        program.solve()
        spread = [getattr(program.spread(), f.name)[kept] for f in fields(Spread)]
        residuals = [program.residual_force**2, program.residual_moment**2, program.mean_noise]
        parts.append((program.wrench[kept], program.shift, residuals, spread))
    wrenches, shifts, residuals, spreads = zip(*parts, strict=True)
    share = np.array([len(wrench) for wrench in wrenches]) / len(needs.time)
    force, moment, noise = (float(each) for each in share @ np.array(residuals))
    return ForceSolution(
        np.concatenate(wrenches),
        Spread(*(np.concatenate(each) for each in zip(*spreads, strict=True))),
        share @ np.array(shifts),
        noise,
        force**0.5,
        moment**0.5,
    )


def windows(n: int, margin: int) -> Iterator[tuple[slice, slice]]:
    """Yield the frames of each window, and which of these are kept."""
    count = 1 if n <= MAX_WINDOW_FRAMES else int(np.ceil(n / (MAX_WINDOW_FRAMES - 2 * margin)))
    edges = np.linspace(0, n, count + 1).round().astype(int).tolist()
    for start, stop in pairwise(edges):
        first = max(0, start - margin)
        yield slice(first, min(n, stop + margin)), slice(start - first, stop - first)
