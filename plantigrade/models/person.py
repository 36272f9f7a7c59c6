"""What is known of a person, from which a Human is made."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plantigrade.bounds import Bounded
from plantigrade.options import Feet, Joints, Kilograms, Metres, Sex

if TYPE_CHECKING:
    from plantigrade.models.human import Human


@dataclass(frozen=True, kw_only=True)
class Person(Bounded):
    """What is known of a person; what is left open comes from the recording or the average adult.

    Every settings class that is about a person inherits these fields.

    Raises:
        ParameterError: If a value is of another type than its field, or out of range.
    """

    activity = "a person"
    ranges = {"height": (0.5, 2.5, "m"), "mass": (5, 300, "kg")}

    height: Metres = None
    """Body height [m]."""
    mass: Kilograms = None
    """Body mass [kg]."""
    sex: Sex = None
    """Sex, which selects the body segment parameters."""
    joints: Joints = None
    """Joint set, named by its number of coordinates."""
    feet: Feet = None
    """Foot model: one box, a box with hinged toes, or five segments with 16 bones."""

    @property
    def known(self) -> dict[str, Any]:
        """What is not left open, by name, as :meth:`Human.create` takes it."""
        fields = ("height", "mass", "sex", "joints", "feet")
        return {name: getattr(self, name) for name in fields if getattr(self, name) is not None}

    def human(self) -> "Human":
        """Return this person; what is left open takes the defaults of :meth:`Human.create`.

        Raises:
            ParameterError: If a value is not allowed.
        """
        from plantigrade.models.human import Human

        return Human.create(**self.known)
