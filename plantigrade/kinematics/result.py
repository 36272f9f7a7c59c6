"""A recording on a body: the result of a fit, whatever kind of recording is fitted."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeVar

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.person import Person
from plantigrade.models.stature import usual_mass
from plantigrade.motion import Markers, Recording, Subject

_Known = TypeVar("_Known", Person, Subject)


@dataclass(frozen=True)
class Fit:
    """A recording on a body."""

    human: Human  #: The person, scaled
    time: Float[Array, " n_frames"]  #: Time of each fitted frame [s]
    qpos: Float[Array, "n_frames nq"]  #: Configuration of each frame, as fitted (not filtered)
    #: The recording, turned so that the person faces x, and cut to the fitted frames
    recording: Recording
    source_kind: str  #: ``"markers"``, ``"skeleton"`` or ``"coordinates"``
    #: The markers that were fitted (recorded positions; gaps are NaN); None where the recording has
    #: no markers
    markers: Markers | None = None
    places: tuple[Attachment, ...] = ()  #: Position of each of these markers on the body
    #: Distance of each marker to its place [m]; NaN where not seen
    residual: Float[Array, "n_frames n_markers"] | None = None
    #: Whether each marker sample was used; False for outliers
    kept: Bool[Array, "n_frames n_markers"] | None = None
    #: Markers of unknown name → the body they were put on
    attached: dict[str, str] = field(default_factory=dict)
    heading: float = 0.0  #: Angle by which the recording was turned about the vertical [rad]
    #: Coordinates that the recording does not show: those of trunk, head and arms follow a
    #: published posture and motion of walking, others keep their value in standing
    assumed: tuple[str, ...] = ()
    #: Factor of the bands of estimated forces, for the noise of a video [1]
    force_band_factor: float = 1.0
    ground: Ground = field(default_factory=Ground)  #: Ground under the feet
    metrics: dict = field(default_factory=dict)  #: Figures of the fit (flat, unit suffix)
    warnings: tuple[str, ...] = ()  #: Notes for the user, one sentence each
    #: Those of them on faults that a body follows without a large marker error
    doubts: tuple[str, ...] = ()


def filled(known: _Known, other: Any) -> _Known:
    """Return a dataclass whose fields of None are taken from another that has them."""
    lacking = [f.name for f in fields(known) if getattr(known, f.name) is None]
    return replace(known, **{name: getattr(other, name, None) for name in lacking})


def human_of(
    person: Person,
    height: float,
    lengths: Mapping[str, float] | None = None,
    age: float | None = None,
) -> Human:
    """Return the person at a height [m]; male, and of usual mass where nothing else is known."""
    mass = person.mass or usual_mass(height, age)[0]
    sex, joints = person.sex or "male", person.joints or "42"
    return Human.create(height, mass, sex, joints, person.feet, lengths)
