"""Types of arrays: the words for them in all signatures; shape and unit stand in the docstring."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
