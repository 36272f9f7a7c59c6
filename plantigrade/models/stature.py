r"""Expected stature from leg length.

Adults: a regression on the height of the greater trochanter in the US Army's ANSUR II, 4,082 men
and 1,986 women [Gordon2014]_. The trochanter lies at 0.516 of stature and the hip joint centres of
[Winter2009]_ at :data:`LEG_SHARE`, hence the factor 0.973 on leg lengths. The regression is more
accurate than a fixed ratio (standard error 0.05 m), because leg length explains stature only in
part.

Legs shorter than any adult's are those of a child, with the fixed ratio. Children below ten years
have relatively short legs; their stature is underestimated by up to 7 %.
"""

import numpy as np

LEG_SHARE = 0.530
"""Height of the hip joint centre relative to stature [1], [Winter2009]_."""
# Intercept [m], slope [1] and standard error [m] of stature on leg length, by sex.
_ADULTS = {
    "male": (0.689, 1.147, 0.036),
    "female": (0.586, 1.207, 0.033),
    None: (0.392, 1.450, 0.043),
}
CHILD_TO_ADULT_LEGS = (0.70, 0.78)
"""Leg lengths between which the estimate changes from the fixed ratio to the regression [m]; 0.1 %
of the women of ANSUR II are below the first, 2 % below the second."""
CHILD_ERROR = 0.05
"""Relative standard error of a child's stature [1]; 3 % between adults of one leg length plus
growth of the legs relative to the trunk."""


def stature_from_legs(leg: float, sex: str | None = None) -> tuple[float, float]:
    """Return the expected stature, and its standard error [m].

    Args:
        leg: Hip joint centre to sole, standing [m].
        sex: ``"female"``, ``"male"``, or None if unknown.

    Example:
        >>> ["{:.2f} ± {:.2f} m".format(*stature_from_legs(leg)) for leg in (0.60, 0.79, 0.93)]
        ['1.13 ± 0.06 m', '1.54 ± 0.04 m', '1.74 ± 0.04 m']

    References:
        [Gordon2014]_, [Winter2009]_.
    """
    start, slope, error = _ADULTS[sex]
    adult, child = np.array([start + slope * leg, error]), np.array([1.0, CHILD_ERROR])
    child *= leg / LEG_SHARE
    stature, error = child + np.interp(leg, CHILD_TO_ADULT_LEGS, (0.0, 1.0)) * (adult - child)
    return float(stature), float(error)
