"""Scales of the rows of the quadratic program of ground forces, by activity."""

from dataclasses import dataclass, replace

import numpy as np

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


# [1] vertical noise of the net force in other movements and running relative to walking; settled on
# the squats, chair and jumps of one person
OTHER_SWAY = 1.5


@dataclass(frozen=True)
class ForceScales:
    """Scales of the rows of the program; forces in body weights (BW)."""

    force: tuple[float, float, float] = (0.005, 0.005, 0.01)  #: Net force [BW]
    moment: float = 0.004  #: Net moment about the centre of mass [BW m]
    #: Noise of the net force [BW]; the vertical one is 1.5 times as large outside walking
    sway: tuple[float, float, float] = (0.02, 0.02, 0.016)
    turn: float = 0.01  #: Noise of the net moment [BW m]
    shift: tuple[float, float, float] = (0.012, 0.012, 0.005)  #: Shift of the centre of mass [m]
    rate: float = 0.7  #: Rate of joint moments [BW m/s]
    bend: tuple[float, float, float] = (25.0, 25.0, 50.0)  #: Second derivative of forces [BW/s²]
    #: Second derivative of foot moments [BW m/s²]
    twist: tuple[float, float, float] = (15.0, 15.0, 3.0)
    free: float = 0.007  #: Free moment [BW m]
    shear: float = 0.1  #: Horizontal force of a seat [BW]
    path: float = 1.5  #: Deviation of the centre of pressure from its mean path, in its SD [1]
    side: float = 0.02  #: Deviation of the lateral force from its mean [BW]
    offset: tuple[float, float] = (0.010, 0.010)  #: Constant offset of a foot's path [m]
    #: Deviation of the load of a foot from its usual share in double support [BW]: events are known
    #: to 10 ms, in which a fifteenth of the weight changes feet
    share: float = 0.06
    effort: float = np.inf  #: Joint moments relative to strength [1]
    loading: float = 20.0  #: Maximum rate of loading after contact [BW/s]
    pace: float = 1.0  #: Ratio of the motion's frequencies to those of walking [1]
    most_free: float = 0.02  #: Maximum free moment per vertical force [m]
    usual: UsualStance = UsualStance()  #: What feet of walkers usually do

    @classmethod
    def of(cls, *, walks: bool, pace: float = 1.0) -> "ForceScales":
        """Return the scales for an activity.

        Without walking, both feet may stand for long, and the motion does not determine their load
        sharing and internal forces; the minimum sum of squared activations is then selected
        [Crowninshield1981]_.

        Running and jumps contain higher frequencies, ``pace`` times those of walking. Rates are
        ``pace`` times and second derivatives ``pace**2`` times as large; the same factor applies to
        errors of the net wrench from masses and soft tissue. The loading rate of landing runners
        and jumpers reaches 100 BW/s.
        """
        usual = cls(effort=np.inf if walks else 1.0)
        if walks and pace == 1.0:
            return usual
        usual = replace(usual, sway=(*usual.sway[:2], OTHER_SWAY * usual.sway[2]))
        if pace == 1.0:
            return usual
        return replace(
            usual,
            force=tuple(pace**2 * f for f in usual.force),
            moment=pace**2 * usual.moment,
            rate=pace * usual.rate,
            bend=tuple(pace**2 * b for b in usual.bend),
            twist=tuple(pace**2 * b for b in usual.twist),
            loading=100.0,
            pace=pace,
        )
