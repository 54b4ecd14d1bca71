"""Observer-based forms of realisations: as many as divisors, and which ones hidden modes allow."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import BlockMatrix, Matrix, Poly, Symbol

from compensator_theory import closed_loop_matrix, observer_forms
from compensator_theory.matrices._invariant_subspaces import derogatory_factor
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank
from compensator_theory.observers import count_observer_forms, youla_forms
from compensator_theory.observers._counting import count_partitions
from compensator_theory.observers._form import ObserverForm
from compensator_theory.roots import number_of_real_roots
from compensator_theory.strategies import matrices

from ..ledger.checks import for_all
from .loops import Loop, hidden_loops, minimal_loops

s = Symbol("s")


def is_form(form: ObserverForm) -> bool:
    """Whether T, K and F satisfy (7.13), and A + BK has the polynomial of the subspace."""
    plant, compensator, T = form.plant, form.compensator, Matrix(form.T)
    K, F = Matrix(compensator.C) * T, T.inv() * Matrix(compensator.B)
    A, B, C = (Matrix(M) for M in (plant.A, plant.B, plant.C))
    return bool(
        Matrix(compensator.A) * T == T * (A + B * K - F * C)
        and characteristic_polynomial(A + B * K, plant.variable) == form.regulator
        and characteristic_polynomial(A - F * C, plant.variable) == form.observer
    )


@for_all(loop=minimal_loops())
def subspaces_are_forms(loop: Loop) -> bool:
    """Every n-dimensional real invariant subspace of the loop of a minimal plant and a minimal
    compensator of order n gives a form: its T is invertible and (7.13) holds.
    """
    forms = observer_forms(*loop)
    return bool(
        forms.is_complete
        and not (forms.rejections or forms.families or forms.undecided)
        and all(is_form(form) for form in forms.forms)
    )


@st.composite
def designs(draw: st.DrawFn) -> tuple[Matrix, Matrix, Matrix]:
    """Draw A, BK and FC of odd order; the plant and the compensator may hide modes."""
    n = draw(st.sampled_from([1, 3]))
    A, B, C = (Matrix(draw(matrices(*size))) for size in ((n, n), (n, 1), (1, n)))
    K, F = (Matrix(draw(matrices(*size))) for size in ((1, n), (n, 1)))
    if draw(st.booleans()):  # the last modes are out of B's reach, or all of them
        reached = draw(st.integers(0, n - 1))
        A[reached:, :reached] = Matrix.zeros(n - reached, reached)
        B[reached:, :] = Matrix.zeros(n - reached, 1)
    used_K, used_F = draw(st.sampled_from([(1, 1), (0, 1), (1, 0), (0, 0)]))
    return A, used_K * B * K, used_F * F * C


@for_all(design=designs())
def only_if_without_minimality(design: tuple[Matrix, Matrix, Matrix]) -> bool:
    """For odd n the loop of every observer-based compensator has two real eigenvalues, counted with
    multiplicity, with whatever modes the plant or the compensator hide.
    """
    A, BK, FC = design
    loop = BlockMatrix([[A, BK], [FC, A + BK - FC]]).as_explicit().as_mutable()
    return number_of_real_roots(characteristic_polynomial(loop, s)) >= 2


@for_all(loop=minimal_loops())
def as_many_as_divisors(loop: Loop) -> bool:
    """There are as many forms as real monic divisors of degree n of the closed-loop polynomial,
    counted by the generating function, and their regulator polynomials differ.
    """
    forms = observer_forms(*loop)
    regulators = {form.regulator for form in forms.forms}
    count = count_observer_forms(forms.characteristic_polynomial, loop[0].n)
    return len(forms.forms) == len(regulators) == count


@for_all(loop=hidden_loops())
def hidden_mode_rule(loop: Loop) -> bool:
    """With a nonderogatory closed loop a factorisation p_R p_O gives a form if and only if no
    unobservable mode of the compensator is a root of p_R and no uncontrollable one a root of p_O.
    """
    plant, compensator = loop
    forms = observer_forms(plant, compensator)
    whole = forms.characteristic_polynomial
    assume(derogatory_factor(closed_loop_matrix(plant, compensator), whole) is None)

    def allowed(p_R: Poly) -> bool:
        hidden = (
            p_R.gcd(compensator.unobservable_modes),
            whole.quo(p_R).gcd(compensator.uncontrollable_modes),
        )
        return all(common.degree() == 0 for common in hidden)

    every_share = len(forms.forms) + len(forms.rejections) == count_observer_forms(whole, plant.n)
    return (
        every_share
        and all(allowed(form.regulator) and is_form(form) for form in forms.forms)
        and not any(allowed(p_R) for p_R, _ in forms.rejections)
    )


@for_all(loop=st.one_of(minimal_loops(excess=1, max_order=2), minimal_loops(excess=2, max_order=1)))
def chains_are_youla_forms(loop: Loop) -> bool:
    """For n_c = n + 1 and n + 2 the chains ker p_R < ker p_R p_Q, with degrees n and n_c, are the
    observers with a Youla parameter: every factorisation p_R p_Q p_O gives one.
    """
    plant, compensator = loop
    whole = characteristic_polynomial(closed_loop_matrix(plant, compensator), plant.variable)
    forms = youla_forms(plant, compensator)
    n, n_c = plant.n, compensator.n
    return len(forms) == count_partitions(whole, (n, n_c - n, n)) and all(
        form.is_verified and form.regulator * form.parameter * form.observer == whole
        for form in forms
    )


@for_all(loop=minimal_loops(max_order=3))
def minimal_loops_are_nonderogatory(loop: Loop) -> bool:
    """The loop of a minimal plant and a minimal compensator has one Jordan block for each
    eigenvalue: I, A~, ..., A~^(n + n_c - 1) are linearly independent.
    """
    plant, compensator = loop
    A = closed_loop_matrix(plant, compensator)
    whole = characteristic_polynomial(A, plant.variable)
    powers = [Matrix.eye(A.rows)]
    for _ in range(A.rows - 1):
        powers.append(powers[-1] * A)
    independent = Matrix.hstack(*(power.reshape(A.rows**2, 1) for power in powers))
    return derogatory_factor(A, whole) is None and rank(independent) == A.rows
