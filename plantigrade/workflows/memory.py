"""Memory that the fit of a recording needs, checked before it is allocated."""

from dataclasses import fields

import numpy as np

from plantigrade.errors import FitError
from plantigrade.io.length import REMEDY, free_memory
from plantigrade.motion import Recording

FIT_BASE_BYTES = 150e6  # Memory of a fit besides its frames [bytes], measured
FIT_BYTES_PER_FRAME = 12e3
"""Memory of a fit for each frame [bytes], measured on 10 minutes at 100 Hz."""
RECORDING_COPIES = 2  # Copies of the recording that a fit makes: turned to face forward, and cut


def require_memory(recording: Recording) -> None:
    """Refuse a recording whose fit would not fit into free memory; the machine would swap."""
    motion = (recording.markers, recording.skeleton, recording.coordinates)
    parts = [part for part in (*motion, *recording.plates) if part is not None]
    arrays = [getattr(part, f.name) for part in parts for f in fields(part)]
    held = sum(each.nbytes for each in arrays if isinstance(each, np.ndarray))
    n_frames = max((len(part.time) for part in motion if part is not None), default=0)
    needed, free = (
        FIT_BASE_BYTES + FIT_BYTES_PER_FRAME * n_frames + RECORDING_COPIES * held,
        free_memory(),
    )
    if needed > free:
        raise FitError(
            f"{recording.source.name} has {n_frames} frames; their fit needs {needed / 1e9:.1f} GB "
            f"of memory, {free / 1e9:.1f} GB are free: close other programs, or {REMEDY}"
        )
