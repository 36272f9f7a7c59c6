"""Stature and body mass of a scaled body: estimated where not given, doubted where wrong."""

from collections.abc import Callable, Sequence

from plantigrade.errors import FitError
from plantigrade.kinematics.unmeasured_joints import bodies_of
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.person import Person
from plantigrade.models.stature import CHILD_TO_ADULT_STATURES, stature_from_legs, usual_mass
from plantigrade.notes import Info

LEG_LENGTHS = ("thigh", "shank", "ankle_height", "foot_length", "foot_width", "pelvis_height",
           "pelvis_width", "pelvis_depth", "lumbar_depth")  # fmt: skip
"""Lengths that markers on pelvis and legs determine."""
BODY_STANDARD_ERROR = 0.03
"""Standard error of a stature that markers on legs and trunk give [m]; 1 to 38 mm off in five
people whose stature is known."""
FROM_LEGS = "the legs alone"
MAX_USUAL_ERROR = 0.008
"""Root-mean-square marker error of a scaled body above which its stature is estimated again [m];
good fits leave 3 to 7 mm."""
MAX_USUAL_DEVIATION = 2.0
"""The same for the difference between its stature and that of its legs [standard errors]."""
WARNING_DEVIATION = 3.0
"""Difference between a given stature and that of the markers above which there is a warning
[standard errors]."""
MAX_DEVIATION = 5.0
"""The same above which it is refused: 0.15 m for a whole body and 0.21 m for legs alone. Of the
6,068 adults of ANSUR II, 0.2 % are taller or shorter by 10 %, or 0.17 m, than their legs suggest
[Gordon2014]_."""


def with_unknown_size(
    human: Human, places: Sequence[Attachment], person: Person, age: float | None = None
) -> tuple[Human, list[str]]:
    """Return a scaled body with the expected stature and mass if they are not given, and notes.

    Args:
        age: Age [years]; None where it is not known.
    """
    notes: list[str] = []
    if person.height is None:
        stature, error, what = _estimate(human, places, person.sex)
        human = human if stature == human.height else _of_stature(human, stature)
        notes += stature_notes(human.height, error, what, age)
    if person.mass is None:
        human = human.with_mass(usual_mass(human.height, age)[0])
    return human, notes


def stature_warnings(
    person: Person,
    human: Human,
    places: Sequence[Attachment],
    marker_error: float,
    free: Callable[[], Human],
    source: object,
) -> list[str]:
    """Return a warning where markers contradict the stature that was given.

    A body of another stature still follows the markers, with a trunk too short or too long and a
    pelvis tilted by 20 degrees, so the marker error alone does not show it.

    Args:
        human: The body, scaled to the markers and to the stature that was given.
        marker_error: Root-mean-square marker error [m].
        free: Scales a body to the markers alone; called only where that error, or the length of the
            legs for the stature, is unusual.
    """
    given = person.height
    if given is None:
        return []
    stature, error, what = _estimate(human, places, person.sex)
    if what != FROM_LEGS:
        expected, spread = stature_from_legs(human.dimensions.leg_length, person.sex)
        if marker_error > MAX_USUAL_ERROR or abs(given - expected) > MAX_USUAL_DEVIATION * spread:
            stature = free().height
    off = abs(given - stature) / error
    if off <= WARNING_DEVIATION:
        return []
    contradiction = (
        f"the stature given is {given:.2f} m, but {what} suggest {stature:.2f} ± {error:.2f} m "
        "(standard error)"
    )
    if off > MAX_DEVIATION:
        raise FitError(
            f"{source}: {contradiction}: give the right one with --height, or check the stature in "
            "the file and the unit of length of its markers"
        )
    return [
        f"{contradiction}; if it is wrong, so are trunk, pelvis tilt and hip flexion: check "
        "--height or the stature in the file."
    ]


def _estimate(
    human: Human, places: Sequence[Attachment], sex: str | None
) -> tuple[float, float, str]:
    """Return the stature that a body scaled to markers has [m], its error [m], and from what."""
    trunk = bodies_of(human, ["lumbar_extension", "neck_extension"])
    if trunk & {place.body for place in places}:
        return human.height, BODY_STANDARD_ERROR, "the markers"
    return (*stature_from_legs(human.dimensions.leg_length, sex), FROM_LEGS)


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
    if age is None and stature - 2 * (error or BODY_STANDARD_ERROR) < CHILD_TO_ADULT_STATURES[0]:
        notes.append(
            f"a person of {stature:.2f} m may be a child, but an estimated stature chooses no "
            "norms: those shown are of adults. Give --height, and --age of a child."
        )
    return notes


def _of_stature(human: Human, stature: float) -> Human:
    """Return a body with the same legs and pelvis and another stature [m]."""
    d = human.dimensions
    lengths = {name: getattr(d, name) for name in LEG_LENGTHS}
    return Human.create(
        stature, human.mass, human.sex, human.joints, human.feet, lengths, human.full_sole
    )
