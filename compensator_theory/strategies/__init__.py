"""Hypothesis strategies for exact compensator theory: polynomials, spectra, plants, problems.

Nothing here filters: every draw is repaired instead of refused, so that examples shrink well and
no health check fails.
"""

from compensator_theory.strategies.compensators import compensators
from compensator_theory.strategies.plants import (
    matrices,
    minimal_plants,
    standard_problems,
    strictly_proper_plants,
)
from compensator_theory.strategies.polynomials import (
    coprime_pairs,
    nonzero_rationals,
    polynomials,
    rationals,
)
from compensator_theory.strategies.spectra import hurwitz_spectra, schur_spectra, spectra

__all__ = [
    "compensators",
    "coprime_pairs",
    "hurwitz_spectra",
    "matrices",
    "minimal_plants",
    "nonzero_rationals",
    "polynomials",
    "rationals",
    "schur_spectra",
    "spectra",
    "standard_problems",
    "strictly_proper_plants",
]
