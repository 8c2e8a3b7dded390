"""Arrays that effects take and give."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.floating]
"""(N, H, W, C) light, samples or code values, see `tacos_framework.contracts.Effect`."""

Moments = tuple[Samples, Samples]
"""Mean [DN] and variance [DN^2]."""
