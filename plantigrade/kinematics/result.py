"""What fitting returns, whatever kind of recording was fitted."""

from dataclasses import dataclass, field

from plantigrade.arrays import Array, Bool, Float
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.motion import Markers, Recording


@dataclass(frozen=True)
class Fit:
    """A recording on a body.

    Attributes:
        human: The person, scaled.
        time: Time of each fitted frame [s].
        qpos: Configuration of each frame, as fitted (not filtered).
        recording: The recording, turned so that the person faces x, and cut to the fitted frames.
        source_kind: ``"markers"``, ``"skeleton"`` or ``"coordinates"``.
        markers: The markers that were fitted (recorded positions; gaps are NaN); None where the
            recording has no markers.
        places: Where each of these markers sits on the body.
        residual: Distance of each marker to its place [m]; NaN where not seen.
        kept: Which marker samples were used; False where a sample was found wrong and left out.
        attached: Markers of unknown name → the body they were put on.
        ignored: Markers that were not used, with the reason.
        heading: Angle by which the recording was turned about the vertical [rad].
        metrics: Figures of the fit (flat, unit suffix).
        warnings: What the user should know, one sentence each.
    """

    human: Human
    time: Float[Array, " n_frames"]
    qpos: Float[Array, "n_frames nq"]
    recording: Recording
    source_kind: str
    markers: Markers | None = None
    places: tuple[Attachment, ...] = ()
    residual: Float[Array, "n_frames n_markers"] | None = None
    kept: Bool[Array, "n_frames n_markers"] | None = None
    attached: dict[str, str] = field(default_factory=dict)
    ignored: dict[str, str] = field(default_factory=dict)
    heading: float = 0.0
    metrics: dict = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
