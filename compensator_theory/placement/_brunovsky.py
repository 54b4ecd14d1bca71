"""Controllability indices and Brunovsky's form of a pair (A, B)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate

import sympy
from sympy import Expr, ImmutableMatrix

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import NotControllableError
from compensator_theory.matrices._certificates import Certified, Residuals, proven
from compensator_theory.matrices._echelon import pivot_columns
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_matrices import (
    RationalMatrix,
    identity_matrix,
    of_rows,
    stacked,
    zero_matrix,
)
from compensator_theory.matrices._linear_algebra import determinant, multiplied, solve
from compensator_theory.polynomials._budget import ask, decimal_digits
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._controllability import (
    controllability_matrix,
    uncontrollable_polynomial,
)


@dataclass(frozen=True)
class BrunovskyForm(Certified, ExactValue):
    r"""A controllable pair as chains of integrators, by feedback and changes of basis.

    .. math:: (A + B F) T = T A_c, \qquad B W = T B_c, \qquad
              \dot z_{i,k} = z_{i,k+1}, \quad \dot z_{i,\kappa_i} = v_i

    Attributes
    ----------
    A, B : sympy.ImmutableMatrix
        n x n and n x m, as given.
    indices : tuple of int
        The controllability index kappa_i of each input, in the order of the inputs: the length of
        its chain; 0 for an input that depends on those before it. As a set they are unique.
    T, F, W : sympy.ImmutableMatrix
        Basis of the states, x = T z, feedback and basis of the inputs, u = F x + W v.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero.
    """

    identity = "(A + B F) T = T A_c, B W = T B_c"

    A: ImmutableMatrix
    B: ImmutableMatrix
    indices: tuple[int, ...]
    T: ImmutableMatrix
    F: ImmutableMatrix
    W: ImmutableMatrix
    exceptional: tuple[Expr, ...]

    def _residuals(self) -> Residuals:
        T, F, n = self.T, self.F, int(self.A.rows)
        moved = multiplied(self.A.row_join(self.B), T.col_join(multiplied(F, T)))  # (A + B F) T
        # T A_c and T B_c are columns of T: a product would bring its rows to one denominator.
        padded, ends = zero_matrix(n, 1).row_join(T), list(accumulate(self.indices))
        before = padded[:, [0 if k in ends else k for k in range(n)]]
        lasts = [end if length else 0 for end, length in zip(ends, self.indices, strict=True)]
        return [moved - before, multiplied(self.B, self.W) - padded[:, lasts]]

    @property
    def A_c(self) -> ImmutableMatrix:
        """Ones above the diagonal inside each chain, and zeros."""
        return chains(self.indices)[0]

    @property
    def B_c(self) -> ImmutableMatrix:
        """A one in the last state of each chain."""
        return chains(self.indices)[1]

    def __str__(self) -> str:
        return f"controllability indices {self.indices}"

    def _repr_latex_(self) -> str:
        indices = ", ".join(map(str, self.indices))
        return displayed(
            rf"(A + B F) T = T A_c, \quad B W = T B_c, \quad \kappa = \left({indices}\right)",
            f"T = {latex(self.T)}",
            f"F = {latex(self.F)}",
            f"W = {latex(self.W)}",
            unless(self.exceptional),
        )


def chains(indices: tuple[int, ...]) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    """Return (A_c, B_c) of chains of integrators of the given lengths."""
    n = sum(indices)
    ends = list(accumulate(indices))
    A = [[int(j == i + 1 and j not in ends) for j in range(n)] for i in range(n)]
    B = [
        [int(k + 1 == end and length > 0) for end, length in zip(ends, indices, strict=True)]
        for k in range(n)
    ]
    return of_rows(A, (n, n)), of_rows(B, (n, len(indices)))


@carrying()
def brunovsky_form(A: MatrixLike, B: MatrixLike) -> BrunovskyForm:
    r"""Bring a controllable pair to Brunovsky's form.

    Parameters
    ----------
    A, B : matrix
        n x n and n x m; with symbols, for generic values of them.

    Raises
    ------
    NotControllableError
        If (A, B) is not controllable; the message names the fixed modes.
    InputError
        If the shapes do not fit.

    Notes
    -----
    The first independent columns of [B AB ... A^(n-1)B], chain by chain, have an inverse whose last
    rows h_i of the chains give the basis h_i A^k. Source: P. Brunovsky, Kybernetika 6 (1970); D. G.
    Luenberger, IEEE Transactions on Automatic Control 12 (1967).

    Examples
    --------
    >>> from compensator_theory import brunovsky_form
    >>> A, B = [[0, 1, 0], [0, 0, 0], [0, 0, 1]], [[0, 0], [1, 0], [1, 1]]
    >>> form = brunovsky_form(A, B)
    >>> form.indices, form.F
    ((2, 1), Matrix([
    [0, 0,  0],
    [0, 1, -1]]))
    """
    a, b = exact_matrix(A, "A"), exact_matrix(B, "B")
    kalman = controllability_matrix(a, b)
    pivots, minor = pivot_columns(kalman)
    n, m = a.rows, b.cols
    if len(pivots) < n:
        fixed = format_polynomial(uncontrollable_polynomial(a, b, variable=_variable(a, b)))
        raise NotControllableError(
            f"(A, B) is not controllable: every A + BK keeps the roots of {fixed}. Remove these "
            "modes from the plant, or change B"
        )
    indices = tuple(sum(pivot % m == i for pivot in pivots) for i in range(m))
    columns = [k * m + i for i in range(m) for k in range(indices[i])]
    ends = [sum(indices[: i + 1]) - 1 for i in range(m) if indices[i]]
    lasts = solve(kalman[:, columns].T, identity_matrix(n)[:, ends]).T  # of the inverse
    if isinstance(lasts, RationalMatrix):  # T has such numbers in each of its entries
        bits = max(entry.height_bits() for entry in lasts.flint_form.entries())
        ask("entries", n**2 * decimal_digits(bits) // 50, "Brunovsky's form, 50 digits as one,")
    rows, tops = [], []
    for k, length in enumerate(filter(None, indices)):
        row = lasts[k, :]
        for _ in range(length):
            rows.append(row)
            row = multiplied(row, a)
        tops.append(row)  # h A^kappa
    basis_inverse = stacked(rows)
    moved = multiplied(basis_inverse, b)
    used = [i for i in range(m) if indices[i]]
    gain = moved.extract(ends, used)
    whole, others = identity_matrix(m), [i for i in range(m) if not indices[i]]
    # One of the others equals a combination of those used, which is subtracted.
    alone = whole[:, others]
    same = moved.extract(ends, others) * alone.T if others else zero_matrix(len(used), m)
    right = (-ImmutableMatrix.vstack(*tops)).row_join(whole[used, :] - same)
    solved = multiplied(whole[:, used], solve(gain, right))
    F, W = solved[:, :n], solved[:, n:] + (alone * alone.T if others else zero_matrix(m, m))
    starts, both = multiplied(b, W), a.row_join(b)
    T_columns: list[ImmutableMatrix] = []
    for i in used:  # (A + B F) t_k = t_(k - 1), from the last, B w, to the first of a chain
        chain = [starts[:, i]]
        for _ in range(1, indices[i]):
            pushed = multiplied(F, chain[-1])  # and not A + B F, all of whose entries are long
            chain.append(multiplied(both, chain[-1].col_join(pushed)))
        T_columns += reversed(chain)
    T = stacked([column.T for column in T_columns]).T
    divisors = [minor, determinant(gain), *denominators_of((T, F, W))]
    result = BrunovskyForm(a, b, indices, T, F, W, exceptional_factors(divisors))
    proven(result.certificate, "form")
    return result


def _variable(a: ImmutableMatrix, b: ImmutableMatrix) -> sympy.Symbol:
    return fresh(names_in_all(a, b), "s", "z", "q", "lambda_")
