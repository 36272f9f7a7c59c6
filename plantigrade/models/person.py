"""Known properties of a person, from which a Human is built."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plantigrade.bounds import Bounded
from plantigrade.options import Feet, Joints, Kilograms, Metres, Sex

if TYPE_CHECKING:
    from plantigrade.models.human import Human


@dataclass(frozen=True, kw_only=True)
class Person(Bounded):
    """Known properties of a person; others come from the recording or the average adult.

    Every settings class about a person inherits these fields.

    Raises:
        ParameterError: If a value has the wrong type or is out of range.
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
        """Known properties by name, as arguments of :meth:`Human.create`."""
        fields = ("height", "mass", "sex", "joints", "feet")
        return {name: getattr(self, name) for name in fields if getattr(self, name) is not None}

    def human(self) -> "Human":
        """Return the person, with the defaults of :meth:`Human.create` for unknown properties.

        Raises:
            ParameterError: If a value is not allowed.
        """
        from plantigrade.models.human import Human

        return Human.create(**self.known)
