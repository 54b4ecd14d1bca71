"""Fixed modes of decentralised output feedback."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import flint
import sympy
from sympy import QQ, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certified
from compensator_theory.matrices._flint_matrices import to_flint
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.polynomials._budget import ask, is_integer, listed, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical, common_divisor, monic
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import Root, certified_roots
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._realisations import Realisation


@dataclass(frozen=True)
class FixedModes(Certified, ExactValue):
    r"""The modes that every :math:`A + \sum_i B_i K_i C_i` has.

    Attributes
    ----------
    plant : Realisation
        (A, B, C).
    polynomial : sympy.Poly
        Monic; its roots are the fixed modes with multiplicity, 1 if there are none.
    centralised : sympy.Poly
        The same for one channel that has all signals: the modes that are not both controllable and
        observable. It divides `polynomial`.
    gains : sympy.ImmutableMatrix
        Block diagonal K with which the polynomials of A and of A + B K C share `polynomial` and
        nothing else: a witness that no more is fixed.
    """

    identity = "the gcd of det(sI - A) and det(sI - A - B K C) is the polynomial"

    plant: Realisation
    polynomial: Poly
    centralised: Poly
    gains: ImmutableMatrix

    def _residuals(self) -> list[Poly]:
        A, B, C, s = self.plant.A, self.plant.B, self.plant.C, self.plant.variable
        before, after = (characteristic_polynomial(M, s) for M in (A, A + B * self.gains * C))
        return [common_divisor(before, after) - self.polynomial]

    def modes(self) -> tuple[Root, ...]:
        """Return the certified fixed modes."""
        return certified_roots(self.polynomial)

    def __str__(self) -> str:
        if not self.polynomial.degree():
            return "no fixed modes"
        return f"the roots of {format_polynomial(self.polynomial)} are fixed"

    def _repr_latex_(self) -> str:
        s = latex(self.polynomial.gen)
        loop = rf"\det\left({s} I - A - \textstyle\sum_i B_i K_i C_i\right)"
        return displayed(rf"\gcd_{{K_i}} {loop} = {latex(self.polynomial)}")


@refusing
def decentralised_fixed_modes(
    plant: RealisationLike,
    channels: Sequence[tuple[Sequence[int], Sequence[int]]],
    *,
    variable: str | Symbol | None = None,
) -> FixedModes:
    r"""Find the modes that no decentralised output feedback moves.

    .. math:: \gcd_{K_1, \ldots, K_\nu} \det\Big(sI - A - \sum_i B_i K_i C_i\Big) =
              \gcd_{I, J} \det \begin{bmatrix} sI - A & B_I \\ C_J & 0 \end{bmatrix}

    over all sets I of inputs and J of outputs with as many of each in every channel (none too,
    which gives det(sI - A)): the determinant on the left is the sum of those on the right, each
    with a minor of the gains.

    Parameters
    ----------
    plant : Realisation, (A, B, C), or input of :func:`realisation`
        Rational, D = 0.
    channels : sequence of (inputs, outputs)
        Lists of indices from 0; each signal in at most one channel. Signals in none are not used.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Raises
    ------
    InputError
        If a channel names a signal that is not there or is in another channel, D is not zero, or an
        entry is symbolic.
    BudgetError
        If there are too many sets.

    Notes
    -----
    Dynamic compensators in the channels do not move them either. Source: S.-H. Wang, E. J. Davison,
    IEEE Transactions on Automatic Control 18 (1973) 473-478; B. D. O. Anderson, D. J. Clements,
    Automatica 17 (1981) 703-712.

    Examples
    --------
    >>> from compensator_theory.geometry import decentralised_fixed_modes
    >>> A, B = [[2, 0, 0], [0, 1, 0], [0, 0, 3]], [[1, 0], [1, 0], [0, 1]]
    >>> plant = A, B, [[1, 0, 0], [0, 1, 1]]
    >>> print(decentralised_fixed_modes(plant, [([0], [0]), ([1], [1])], variable="s"))
    the roots of s - 1 are fixed
    >>> print(decentralised_fixed_modes(plant, [([0, 1], [0, 1])], variable="s"))
    no fixed modes
    """
    source = realisation(plant, variable)
    if not source.D.is_zero_matrix:
        raise InputError("D is not zero; take the direct part out of the outputs first")
    symbols = sorted(map(str, (source.A.row_join(source.B).free_symbols | source.C.free_symbols)))
    if symbols:
        raise InputError(f"substitute numbers for {', '.join(symbols)} first")
    read = _channels(channels, source.B.cols, source.C.rows)
    everything = [(tuple(range(source.B.cols)), tuple(range(source.C.rows)))]
    plant_matrices = source.A, source.B, source.C
    fixed = _common(*plant_matrices, read, source.variable)
    whole = _common(*plant_matrices, everything, source.variable)
    gains = _witness(*plant_matrices, read, fixed)
    return FixedModes(source, fixed, whole, gains)


Channels = list[tuple[tuple[int, ...], tuple[int, ...]]]


def _channels(
    channels: Sequence[tuple[Sequence[int], Sequence[int]]], inputs: int, outputs: int
) -> Channels:
    example = "write one pair of lists for each channel, as in [([0], [0]), ([1], [1, 2])]"
    try:
        pairs = [(i, o) for i, o in listed(channels, "entries", "the list of channels")]
    except (TypeError, ValueError) as error:
        raise InputError(f"the channels {repr_of(channels)} cannot be read; {example}") from error
    read = [(_signals(i, "inputs"), _signals(o, "outputs")) for i, o in pairs]
    for side, size, name in ((0, inputs, "input"), (1, outputs, "output")):
        used = [index for pair in read for index in pair[side]]
        bad = [i for i in used if not (is_integer(i) and 0 <= i < size)]
        if bad or len(set(used)) < len(used):
            raise InputError(
                f"the channels use the {name}s {repr_of(used)}; each of the {size} is numbered "
                f"from 0 and belongs to one channel at most; {example}"
            )
    if not read:
        raise InputError(f"there is no channel; {example}")
    return read


def _signals(indices: Sequence[int], name: str) -> tuple[int, ...]:
    return tuple(listed(indices, "entries", f"the list of {name} of a channel"))


def _common(A: Matrix, B: Matrix, C: Matrix, channels: Channels, variable: Symbol) -> Poly:
    count = math.prod(math.comb(len(i) + len(o), len(i)) for i, o in channels)
    ask("terms", count, "the number of minors of the decentralised plant")
    ask("entries", len(channels) * A.rows**3, "the minors of the decentralised plant")
    divisor = Poly(0, variable, domain=QQ)
    choices = [
        [
            (i, o)
            for size in range(min(len(inputs), len(outputs)) + 1)
            for i in itertools.combinations(inputs, size)
            for o in itertools.combinations(outputs, size)
        ]
        for inputs, outputs in channels
    ]
    for choice in itertools.product(*choices):
        columns = [index for i, _ in choice for index in i]
        rows = [index for _, o in choice for index in o]
        upper = (-A).row_join(B.extract(list(range(A.rows)), columns))
        lower = C.extract(rows, list(range(A.rows))).row_join(sympy.zeros(len(rows)))
        minor = _interpolated(to_flint(upper.col_join(lower)), A.rows)
        divisor = divisor.gcd(from_flint_polynomial(minor, variable))
        if divisor.degree() == 0:
            break
    return monic(canonical(divisor))


def _interpolated(matrix: flint.fmpq_mat, size: int) -> flint.fmpq_poly:
    """Return the determinant with s added to the first entries of the diagonal, by its values."""
    newton: list[flint.fmpq] = []
    matrix = flint.fmpq_mat(matrix)  # a copy, since it is changed
    for point in range(size + 1):
        value = matrix.det()
        for k, coefficient in enumerate(newton):  # divided differences at 0, 1, 2, ...
            value = (value - coefficient) / (point - k)
        newton.append(value)
        for k in range(size):
            matrix[k, k] += 1
    interpolant = flint.fmpq_poly([0])
    for k in range(size, -1, -1):
        interpolant = interpolant * flint.fmpq_poly([-k, 1]) + newton[k]
    return interpolant


def _witness(A: Matrix, B: Matrix, C: Matrix, channels: Channels, fixed: Poly) -> ImmutableMatrix:
    """Return gains that move every other mode; almost all do."""
    for trial in itertools.count(1):
        K = Matrix.zeros(B.cols, C.rows)
        for inputs, outputs in channels:
            for i, j in itertools.product(inputs, outputs):
                K[i, j] = (trial * (3 * i + 5 * j + 1) + (i + 2 * j + 2) ** trial) % (trial + 8) - 4
        before, after = (characteristic_polynomial(M, fixed.gen) for M in (A, A + B * K * C))
        rest = [p.exquo(fixed) for p in (before, after)]
        if rest[0].gcd(rest[1]).degree() == 0:
            return ImmutableMatrix(K)
    raise AssertionError("unreachable")
