"""Who somebody is, as far as it is known: what turns into a Human."""

from dataclasses import dataclass

from plantigrade.models.human import Human


@dataclass(frozen=True, kw_only=True)
class Person:
    """What is known of a person; everything may be left open.

    Attributes:
        height: Stature [m].
        mass: Body mass [kg].
        sex: ``"female"`` or ``"male"``.
        joints: Joint set: ``"42"``, ``"43"``, ``"58"`` or ``"66"``.
        feet: ``"rigid"``, ``"two-segment"`` or ``"multi-segment"``; the joint set's own if None.
    """

    height: float | None = None
    mass: float | None = None
    sex: str | None = None
    joints: str | None = None
    feet: str | None = None

    @property
    def known(self) -> dict[str, float | str]:
        """What is not left open, by name, as :meth:`Human.create` takes it."""
        return {k: v for k, v in vars(self).items() if v is not None}

    def human(self) -> Human:
        """Return this person; what is left open takes the defaults of :meth:`Human.create`.

        Raises:
            ParameterError: If a value is not allowed.
        """
        return Human.create(**self.known)  # type: ignore[arg-type]
