"""Nuisances of an expectation, capture by capture: its light, pose and focus."""

from tacos_gap.nuisances.agreement import shares_of_priors
from tacos_gap.nuisances.beyond_stated import light_beyond_stated
from tacos_gap.nuisances.expectation import disturbed
from tacos_gap.nuisances.freedom import POSE_TERMS, Freedom, freedoms_of, stated
from tacos_gap.nuisances.marginal import Marginal
from tacos_gap.nuisances.noisy_expectation import expectation_noise, with_noise_of_expectation
from tacos_gap.nuisances.registration import registered

__all__ = [
    "POSE_TERMS",
    "Freedom",
    "Marginal",
    "disturbed",
    "expectation_noise",
    "freedoms_of",
    "light_beyond_stated",
    "registered",
    "shares_of_priors",
    "stated",
    "with_noise_of_expectation",
]
