"""Values that must be the same everywhere, each in one place."""

GRAVITY = 9.81
"""Acceleration of gravity [m/s²], as in every model."""

SIDES = ("r", "l")
"""Order of the sides wherever an array has an axis for them."""

FRICTION = 0.8
"""Coefficient of friction of a shoe or a bare foot on a dry floor."""
