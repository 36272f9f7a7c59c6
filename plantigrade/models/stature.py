r"""The expected stature of a person whose legs alone are known.

Adults: a regression on the height of the greater trochanter in the US Army's ANSUR II, 4,082 men
and 1,986 women [Gordon2014]_. It lies at 0.516 of stature, where the hip joint centres of
[Winter2009]_ are at :data:`LEG_SHARE`, so leg lengths enter times 0.973. A regression does better
than the fixed share (standard error 0.05 m), because long legs belong to tall people only in part.

Legs shorter than any adult's are a child's, for which the fixed share is used. Children below ten
years have relatively short legs and come out up to 7 % too short.
"""

import numpy as np

LEG_SHARE = 0.530
"""Hip joint centre above the ground, of stature [Winter2009]_."""
# Intercept [m], slope, and standard error [m] of stature on leg length; unknown sex: both alike.
_ADULTS = {
    "male": (0.689, 1.147, 0.036),
    "female": (0.586, 1.207, 0.033),
    None: (0.392, 1.450, 0.043),
}
ADULT_LEGS = (0.70, 0.78)
"""Leg lengths between which the estimate changes from the share to the regression [m]: 0.1 % of the
women of ANSUR II are below the first, 2 % below the second."""
CHILD_ERROR = 0.05
"""Standard error of a child's stature, as a share: 3 % between adults of one leg length and what
legs grow relative to the trunk."""


def stature_from_legs(leg: float, sex: str | None = None) -> tuple[float, float]:
    """Return the expected stature, and its standard error [m].

    Args:
        leg: Hip joint centre to sole, standing [m].
        sex: ``"female"``, ``"male"``, or None where it is not known.

    Example:
        >>> ["{:.2f} ± {:.2f} m".format(*stature_from_legs(leg)) for leg in (0.60, 0.79, 0.93)]
        ['1.13 ± 0.06 m', '1.54 ± 0.04 m', '1.74 ± 0.04 m']

    References:
        [Gordon2014]_, [Winter2009]_.
    """
    start, slope, error = _ADULTS[sex]
    adult, child = np.array([start + slope * leg, error]), np.array([1.0, CHILD_ERROR])
    child *= leg / LEG_SHARE
    stature, error = child + np.interp(leg, ADULT_LEGS, (0.0, 1.0)) * (adult - child)
    return float(stature), float(error)
