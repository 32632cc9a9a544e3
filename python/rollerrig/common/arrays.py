"""Types of arrays: the words for them in all signatures; a docstring has shape and unit."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
