r"""Expected stature from leg length, and expected body mass from stature.

Adults: a regression on the height of the greater trochanter in the US Army's ANSUR II, 4,082 men
and 1,986 women [Gordon2014]_. The trochanter lies at 0.516 of stature and the hip joint centres of
[Winter2009]_ at :data:`LEG_SHARE`, hence the factor 0.973 on leg lengths. The regression is more
accurate than a fixed ratio (standard error 0.05 m), because leg length explains stature only in
part.

Legs shorter than any adult's are those of a child, with the fixed ratio. Children below ten years
have relatively short legs; their stature is underestimated by up to 7 %.

**Mass.** Children: median body mass index of the growth charts of the United States
[Kuczmarski2002]_ at the age at which the median child has that stature, mean of girls and boys.
Adults: 22 kg/m², between the chart's medians at 20 years, 21.7 of women and 23.0 of men.
"""

import numpy as np

from plantigrade.data_files import number_table

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
ADULT_AGE = 18.0  # [years] age from which a person is an adult
ADULT_BMI = 22.0  # [kg/m²] body mass index of adults
ADULT_BMI_SPREAD = 0.15
"""Relative standard deviation of the body mass index of adults [1]; 0.14 to 0.15 in 6,068 soldiers
[Gordon2014]_, 0.16 at 18 years in the chart."""
CHILD_TO_ADULT_STATURES = (1.45, 1.60)
"""Statures between which the index for unknown age changes from children to adults [m]; 1 % of
women are shorter than the first, a third are shorter than the second."""
_CHILDREN = np.array(
    [*number_table("plantigrade.models", "children.csv", 3).values()]
)  # stature [m], body mass index [kg/m²], its relative standard deviation [1]


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


def usual_mass(height: float, age: float | None = None) -> tuple[float, float]:
    """Return the expected body mass at a stature, and its standard deviation [kg].

    Args:
        height: Stature [m].
        age: Age [years]; None if unknown.

    Example:
        >>> ["{:.0f} ± {:.0f} kg".format(*usual_mass(height)) for height in (1.04, 1.44, 1.81)]
        ['17 ± 1 kg', '36 ± 5 kg', '72 ± 11 kg']
        >>> "{:.0f} ± {:.0f} kg".format(*usual_mass(1.44, age=40))
        '46 ± 7 kg'

    References:
        [Kuczmarski2002]_, [Gordon2014]_.
    """
    stature, index, spread = _CHILDREN.T
    child = np.array([np.interp(height, stature, index), np.interp(height, stature, spread)])
    grown = (
        np.interp(height, CHILD_TO_ADULT_STATURES, (0.0, 1.0))
        if age is None
        else float(age >= ADULT_AGE)
    )
    index, spread = child + grown * (np.array([ADULT_BMI, ADULT_BMI_SPREAD]) - child)
    mass = float(index) * height**2
    return mass, mass * float(spread)
