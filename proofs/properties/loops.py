"""Loops in which plant and compensator are minimal, or the compensator has hidden modes."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import Matrix, diag

from compensator_theory import Realisation, place_poles, polynomial_from_roots, realisation
from compensator_theory.generators.plants import unimodular_matrices
from compensator_theory.strategies import polynomials, spectra, strictly_proper_plants
from compensator_theory.transfer_functions import TransferFunction

Loop = tuple[Realisation, Realisation]


@st.composite
def minimal_loops(draw: st.DrawFn, excess: int = 0, max_order: int = 3) -> Loop:
    """Draw a minimal SISO plant of order n and a minimal compensator of order n + excess.

    The closed-loop spectrum is drawn, so that every real factor of its polynomial is rational; the
    compensator places it, in a basis that hides its structure.

    Examples
    --------
    >>> from hypothesis import given
    >>> from proofs.properties.loops import minimal_loops
    >>> @given(minimal_loops())
    ... def check(loop):
    ...     assert loop[0].is_minimal and loop[1].is_minimal
    >>> check()
    """
    plant = draw(strictly_proper_plants(max_order=max_order))
    roots = draw(spectra(2 * plant.order + excess))
    wanted = polynomial_from_roots(roots, "s")
    placed = place_poles(plant, wanted, feedback=+1).compensator
    assume(placed.is_coprime and placed.is_strictly_proper)
    compensator = realisation(placed)
    return realisation(plant), compensator.in_basis(draw(unimodular_matrices(compensator.n)))


@st.composite
def hidden_loops(draw: st.DrawFn, max_order: int = 3) -> Loop:
    """Draw a minimal SISO plant and a compensator of its order, diagonal, with hidden modes.

    Each mode is reached and seen, not reached, not seen, or neither.

    Examples
    --------
    >>> from hypothesis import given
    >>> from proofs.properties.loops import hidden_loops
    >>> @given(hidden_loops())
    ... def check(loop):
    ...     assert loop[0].is_minimal and loop[0].n == loop[1].n
    >>> check()
    """
    n = draw(st.integers(1, max_order))
    D = polynomial_from_roots(draw(spectra(n)), "s")
    N = draw(polynomials("s", 0, n - 1))
    assume(D.gcd(N).degree() == 0)
    reached = draw(st.lists(st.booleans(), min_size=n, max_size=n))
    seen = draw(st.lists(st.booleans(), min_size=n, max_size=n))
    modes = draw(st.lists(st.integers(-9, 9), min_size=n, max_size=n, unique=True))
    B_c = Matrix([int(here) for here in reached])
    C_c = Matrix([[draw(st.integers(1, 3)) * here for here in seen]])
    return realisation(TransferFunction(N, D)), Realisation(diag(*modes), B_c, C_c)
