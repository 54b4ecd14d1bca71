"""Loops in which plant and compensator are minimal, or the compensator has hidden modes."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import Matrix, diag, zeros

from compensator_theory import Realisation, place_poles, polynomial_from_roots, realisation
from compensator_theory.strategies import polynomials, spectra, strictly_proper_plants
from compensator_theory.strategies.plants import unimodular_matrices
from compensator_theory.systems._transfer_functions import TransferFunction

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
    target = polynomial_from_roots(roots, "s")
    placed = place_poles(plant, target, feedback=+1).compensator
    assume(placed.is_coprime and placed.is_strictly_proper)
    compensator = realisation(placed)
    return realisation(plant), compensator.in_basis(draw(unimodular_matrices(compensator.n)))


@st.composite
def hidden_loops(draw: st.DrawFn, max_order: int = 3) -> Loop:
    """Draw a minimal SISO plant and a compensator of its order n with hidden modes.

    The closed-loop spectrum is drawn, so that every real factor of its polynomial is rational: the
    plant places it around the minimal part of the compensator, of order r <= n. The other n - r
    modes are not reached, not seen, or neither.

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
    r = draw(st.integers(0, n))
    if r:
        D_c = draw(polynomials("s", r, r, is_monic=True))
        direct = TransferFunction(draw(polynomials("s", 0, r - 1)), D_c)
        assume(direct.is_coprime)
        target = polynomial_from_roots(draw(spectra(n + r)), "s")
        plant = place_poles(direct, target, feedback=+1).compensator
        minimal = realisation(direct)
        blocks = [Matrix(M) for M in (minimal.A, minimal.B, minimal.C)]
    else:
        D = polynomial_from_roots(draw(spectra(n)), "s")
        plant = TransferFunction(draw(polynomials("s", 0, n - 1)), D)
        blocks = [zeros(0, 0), zeros(0, 1), zeros(1, 0)]
    assume(plant.is_coprime)
    modes = draw(st.lists(st.integers(-9, 9), min_size=n - r, max_size=n - r, unique=True))
    hidden = [draw(st.sampled_from([(0, 0), (0, 1), (1, 0)])) for _ in modes]
    A_c = diag(blocks[0], *modes)
    B_c = blocks[1].col_join(Matrix(n - r, 1, [reached for reached, _ in hidden]))
    C_c = blocks[2].row_join(Matrix(1, n - r, [output_entry for _, output_entry in hidden]))
    compensator = Realisation(A_c, B_c, C_c)
    return realisation(plant), compensator.in_basis(draw(unimodular_matrices(n)))
