"""Disagreement of captures about the camera's pose: what all of them share is no nuisance of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import chi2

from tacos_gap.nuisances.freedom import POSE_TERMS

CONFIDENCE = 0.95
"""Probability with which poses are off by no more than said: of two captures that agree by chance little is
said, of ten much."""

LEAST_SHARE = dict(zip(POSE_TERMS, (0.06, 0.06, 0.17, 0.6, 0.2, 0.2), strict=True))
"""Of a prior's deviation at least: what moves pixels of a small image by 0.03 px, the equivalence margin of
displacements."""

WORTH_IT = 0.5
"""Share above which a prior stays what it is."""

_ALIKE = (POSE_TERMS[:2], POSE_TERMS[2:3], POSE_TERMS[3:4], POSE_TERMS[4:])  # x and y are of one size


def shares_of_priors(poses: Sequence[Mapping[str, float]], groups: Sequence[str]) -> dict[str, float]:
    """Scatter of each term of pose from capture to capture, over what its prior allows.

    Poses that are off capture by capture scatter as their prior says. Where they hardly do, the prior is too
    wide, and what they have in common is for an effect to explain: a camera that is turned, say. The scatter
    about the common value is taken at the upper end of its interval (Student 1908), so few captures keep
    their prior.

    - `poses`: for each capture what its pose is off by, in standard deviations of the priors.
    - `groups`: what was set up together: captures of one group have one pose, and count once.

    >>> turned = [dict.fromkeys(POSE_TERMS, 0.6 + off) for off in (0.01, 0, 0.02, 0)]
    >>> sorted(shares_of_priors(turned, ["a", "b", "c", "d"]))
    ['rotation_deg', 'scale', 'shift_x_px', 'shift_y_px', 'tilt_x_deg', 'tilt_y_deg']
    >>> shares_of_priors(turned, ["a"] * 4)
    {}
    """
    names = list(dict.fromkeys(groups))
    free = len(names) - 1
    if free < 1:
        return {}
    found: dict[str, float] = {}
    for alike in _ALIKE:
        values = np.array([[pose[term] for term in alike] for pose in poses])
        means = np.array([values[np.array(groups) == name].mean(axis=0) for name in names])
        scatter = float(np.sum((means - means.mean(axis=0)) ** 2))
        share = float(np.sqrt(scatter / chi2.ppf(1 - CONFIDENCE, free * len(alike))))
        if share < WORTH_IT:
            found |= {term: max(share, LEAST_SHARE[term]) for term in alike}
    return found
