"""Physical constants and conventions shared by all modules."""

GRAVITY = 9.81  #: Acceleration of gravity [m/s²]
STANDARD_GRAVITY = 9.80665  #: The standard one, which OpenSim assumes [m/s²]
SIDES = ("r", "l")
"""Order of the sides in every array with an axis for them."""
SIDE_NAMES = {"r": "right", "l": "left"}  #: Side → its name in texts
FRICTION = 0.8  #: Coefficient of friction of a shoe or bare foot on a dry floor
MAX_LOAD = 60.0  #: Largest load at one place of the body [kg]; soldiers march with up to 60
