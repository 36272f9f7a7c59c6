"""Stature and body mass of a scaled body where nobody gives them, and what to say of them."""

from collections.abc import Sequence

from plantigrade.kinematics.unmeasured import bodies_of
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.person import Person
from plantigrade.models.stature import stature_from_legs
from plantigrade.models.usual_mass import GROWN, usual_mass
from plantigrade.notes import Info

OF_LEGS = ("thigh", "shank", "ankle_height", "foot_length", "foot_width", "pelvis_height",
           "pelvis_width", "pelvis_depth", "lumbar_depth")  # fmt: skip
"""Lengths that markers on pelvis and legs tell."""
BODY_ERROR = 0.03
"""Standard error of a stature that markers on legs and trunk give [m]; 1 to 38 mm off in five
people whose stature is known."""


def with_unknown_size(
    human: Human, places: Sequence[Attachment], person: Person, age: float | None = None
) -> tuple[Human, list[str]]:
    """Return a scaled body with the stature and mass to expect where nobody gives them, and notes.

    Args:
        human: The body, scaled to markers.
        places: Where these markers sit.
        person: What is known of the person.
        age: Age [years]; None where it is not known.
    """
    notes: list[str] = []
    if person.height is None:
        trunk = bodies_of(human, ["lumbar_extension", "neck_extension"])
        error, what = BODY_ERROR, "the markers"
        if not trunk & {place.body for place in places}:
            d = human.dimensions
            leg = d.thigh + d.shank + d.ankle_height
            stature, error = stature_from_legs(leg, person.sex)
            human, what = _of_stature(human, stature), "the legs alone"
        notes += stature_notes(human.height, error, what, age)
    if person.mass is None:
        human = human.with_mass(usual_mass(human.height, age)[0])
    return human, notes


def stature_notes(
    stature: float, error: float | None, what: str, age: float | None = None
) -> list[str]:
    """Return the notes on a stature [m], and its standard error [m], estimated from something."""
    band = f" ± {error:.2f} m (standard error)" if error else " m"
    notes: list[str] = [
        Info(
            f"the stature is not in the file; {stature:.2f}{band} was estimated from {what} (set "
            "it with --height)."
        )
    ]
    if age is None and stature - 2 * (error or BODY_ERROR) < GROWN[0]:
        notes.append(
            f"somebody of {stature:.2f} m may be a child, but an estimated stature chooses no "
            "norms: those shown are of adults. Give --height, and --age of a child."
        )
    return notes


def _of_stature(human: Human, stature: float) -> Human:
    """Return a body with the same legs and pelvis and another stature [m]."""
    d = human.dimensions
    lengths = {name: getattr(d, name) for name in OF_LEGS}
    return Human.create(
        stature, human.mass, human.sex, human.joints, human.feet, lengths, human.full_sole
    )
