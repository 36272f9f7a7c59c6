"""What feet of healthy walkers usually do in a stance: paths of pressure, sideways force, transfer.

All curves are means of eight stances and double supports of the same three people.
"""

from dataclasses import dataclass

PHASE = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Share of a stance, or of a double support, at which its curves are given [1]."""
LEAN = (-0.3, -0.16, -0.04, 0.08, 0.2, 0.32, 0.44, 0.56, 0.68, 0.8, 0.92)
"""Forward lean of the shank at which the roll-over shape is given [rad]."""

Curve = tuple[float, ...]


@dataclass(frozen=True)
class UsualStance:
    """Usual curves of the centre of pressure, the sideways force and the transfer of load."""

    #: Centre of pressure forward of the ankle over :data:`PHASE` [foot lengths]: of runners, and
    #: where shanks do not show it
    cop_forward: Curve = (-0.06, -0.025, 0.09, 0.205, 0.345, 0.45, 0.485, 0.497, 0.48, 0.37, 0.14)
    #: The same outward [foot lengths]
    cop_outward: Curve = (0.01, 0.03, 0.05, 0.06, 0.065, 0.085, 0.095, 0.095, 0.065, 0.01, -0.04)
    #: Force towards the other foot over :data:`PHASE` [BW]
    force_inward: Curve = (0.0, 0.0, 0.053, 0.058, 0.045, 0.036, 0.042, 0.054, 0.047, 0.005, 0.0)
    #: Share of the rear foot in the vertical force of a double support over :data:`PHASE`, from the
    #: start of the front foot's contact interval to the end of the rear foot's [1]
    rear_share: Curve = (0.98, 0.90, 0.78, 0.66, 0.54, 0.43, 0.315, 0.21, 0.12, 0.04, 0.0)
    #: Roll-over shape: centre of pressure forward of the ankle over :data:`LEAN` [foot lengths]. It
    #: hardly depends on speed [Hansen2004]_; people not among the three differ from it by 8 mm,
    #: from their mean path over a stance by 14 mm
    roll_over: Curve = (-0.10, -0.044, 0.0, 0.109, 0.332, 0.502, 0.497, 0.488, 0.443, 0.353, 0.229)
    #: Standard deviation about each person's mean path forward, share of stance and [m]
    cop_forward_spread: tuple[Curve, Curve] = (
        (0.0, 0.1, 0.4, 0.5, 0.75, 0.9, 1.0),
        (0.012, 0.009, 0.008, 0.008, 0.005, 0.012, 0.022),
    )
    #: The same outward
    cop_outward_spread: tuple[Curve, Curve] = (
        (0.0, 0.2, 0.4, 0.6, 0.8, 1.0),
        (0.007, 0.006, 0.005, 0.006, 0.004, 0.012),
    )
    #: Half of the standard deviation about each person's mean shape, lean [rad] and [m]: with all
    #: of it the settled half has 12.7 mm of error of the centre of pressure in place of 9.9
    roll_over_spread: tuple[Curve, Curve] = (
        (-0.23, -0.04, 0.08, 0.2, 0.32, 0.8),
        (0.008, 0.006, 0.006, 0.007, 0.005, 0.005),
    )
