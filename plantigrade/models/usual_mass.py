"""Expected body mass from stature.

Children: median body mass index of the growth charts of the United States [Kuczmarski2002]_ at the
age at which the median child has that stature, mean of girls and boys. Adults: 22 kg/m², between
the chart's medians at 20 years, 21.7 of women and 23.0 of men.
"""

import numpy as np

from plantigrade.data_files import number_table

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
