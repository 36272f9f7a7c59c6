"""Figures of a run: a mapping that names the nearest key where one is misspelt."""

from typing import Any

from plantigrade.errors import FigureNotFound, known_names


class Figures(dict[str, Any]):
    """Figures by key: flat, in snake_case, unit as suffix.

    Example:
        >>> Figures(walking_speed_m_s=1.3)["walking_speed"]
        Traceback (most recent call last):
        ...
        plantigrade.errors.FigureNotFound: no figure 'walking_speed'; did you mean ...
    """

    def __missing__(self, key: str) -> Any:
        """Refuse a key that is not there."""
        raise FigureNotFound(f"no figure {key!r}; {known_names(str(key), list(self))}")
