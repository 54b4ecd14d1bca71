"""Hypothesis strategies for exact compensator theory: polynomials, spectra, plants, problems.

Nothing here filters: every draw is repaired instead of refused, so that examples shrink well and
no health check fails. Where shares of kinds are stated, the kind is the first thing drawn, from a
list with as many entries as its weight: what comes first is not changed when Hypothesis repeats
parts of a draw elsewhere in it. It varies each draw a few times, so that the shares among 100 draws
scatter by about 0.1 around those that are stated, more than independent ones would.
"""

from __future__ import annotations

from compensator_theory.libraries import require_library

try:
    from compensator_theory.strategies.compensators import compensators
    from compensator_theory.strategies.corners import (
        boundary_loops,
        boundary_polynomials,
        derogatory_loops,
        exactly_proper_plants,
        irrational_polynomials,
        minimal_mimo_plants,
        nearly_cancelling_plants,
        noncoprime_pairs,
        plants_and_compensators,
        plants_with_common_factor,
        plants_with_gain,
    )
    from compensator_theory.strategies.loops import loops_with_spectrum
    from compensator_theory.strategies.plants import (
        hurwitz_matrices,
        matrices,
        minimal_plants,
        schur_matrices,
        semidefinite_matrices,
        standard_problems,
        strictly_proper_plants,
        symmetric_matrices,
    )
    from compensator_theory.strategies.polynomials import (
        coprime_pairs,
        nonzero_rationals,
        polynomials,
        rationals,
    )
    from compensator_theory.strategies.spectra import hurwitz_spectra, schur_spectra, spectra
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "hypothesis":
        raise

    def __getattr__(name: str) -> object:
        """Return a strategy; without Hypothesis, raise an error that names the extra."""
        if name in __all__:
            require_library("hypothesis")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "boundary_loops",
    "boundary_polynomials",
    "compensators",
    "coprime_pairs",
    "derogatory_loops",
    "exactly_proper_plants",
    "hurwitz_matrices",
    "hurwitz_spectra",
    "irrational_polynomials",
    "loops_with_spectrum",
    "matrices",
    "minimal_mimo_plants",
    "minimal_plants",
    "nearly_cancelling_plants",
    "noncoprime_pairs",
    "nonzero_rationals",
    "plants_and_compensators",
    "plants_with_common_factor",
    "plants_with_gain",
    "polynomials",
    "rationals",
    "schur_matrices",
    "schur_spectra",
    "semidefinite_matrices",
    "spectra",
    "standard_problems",
    "strictly_proper_plants",
    "symmetric_matrices",
]
