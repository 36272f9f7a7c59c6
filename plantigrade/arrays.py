"""Array types: shapes in the type, units in the docstring."""

import numpy as np
from jaxtyping import Bool, Float, Int

Array = np.ndarray

__all__ = ["Array", "Bool", "Float", "Int"]
