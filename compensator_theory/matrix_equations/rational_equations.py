"""Sylvester's and Stein's equations over the rationals, in python-flint's integers."""

from functools import reduce
from operator import add, mul

import flint
from sympy import ImmutableMatrix, Matrix

from compensator_theory.matrices.flint_matrices import from_flint, rational_in_flint, to_flint
from compensator_theory.polynomials.budget import ask, decimal_digits

_PROBES = 2
_SMALL_PRIMES = 2**16 * 3**8 * 5**4 * 7**4 * 11**2 * 13**2  # combinations may cancel these
_SPARE_BITS = 64 + _SMALL_PRIMES.bit_length()
_DOUBLINGS = 3  # of the modulus, until a step of the lifting is as long as the matrix's entries


def solve_rational(
    a: Matrix, b: Matrix, c: Matrix, *, stein: bool = False
) -> ImmutableMatrix | None:
    r"""Solve A X + X B = C, or X = A X B + C; None where the solution is not unique.

    .. math:: X p(-B) = -\sum_k p_k \sum_{i+j=k-1} A^i C (-B)^j, \qquad p(A) = 0

    The determinant of p(-B), a resultant, is known before the work begins, and with it how long the
    entries of X may be.

    Raises
    ------
    BudgetError
        If the solution has too many digits.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrix_equations.rational_equations import solve_rational
    >>> solve_rational(Matrix([[2]]), Matrix([[1]]), Matrix([[1]]))
    Matrix([[1/3]])
    """
    (A, over_a), (B, over_b), (C, over_c) = (to_flint(M).numer_denom() for M in (a, b, c))
    if stein:
        step = over_a * over_b  # A^k X B^k = step^k X - T_k with T_(k+1) = A T_k B + step^(k+1) C
        M, C = B, C * step
        p = A.charpoly().coeffs()
        modes = flint.fmpz_poly([p[k] * step**k for k in range(len(p) - 1, -1, -1)])
    else:
        step = over_a.lcm(over_b)
        A, M, C = A * (step // over_a), B * -(step // over_b), C * step
        modes = A.charpoly()
        p = modes.coeffs()
    divisor = abs(modes.resultant(M.charpoly()))
    if divisor == 0:
        return None
    _ask_for_digits(C, int(divisor).bit_length(), "a hundred")  # may be cancelled in part
    value, total = (_stein if stein else _sylvester)(A, M, C, p, step)
    numerators, denominator = _by_inverse(value, total)
    return from_flint(flint.fmpq_mat(numerators) / (denominator * over_c))


def _ask_for_digits(shape: flint.fmpz_mat, bits: int, unit: str) -> None:
    size = shape.nrows() * shape.ncols() * (1 + decimal_digits(bits) // 100)
    ask("entries", size, f"the solution of the matrix equation, {unit} digits counted as one,")


def _sylvester(
    A: flint.fmpz_mat, M: flint.fmpz_mat, C: flint.fmpz_mat, p: list[flint.fmpz], _step: flint.fmpz
) -> tuple[flint.fmpz_mat, flint.fmpz_mat]:
    """Sum p_k M^k, and p_k (A^k X - X M^k) with the other sign."""
    power = M**0
    total, value, term = C * 0, power * 0, C * 0
    for k, coefficient in enumerate(p):
        total, value = total - term * coefficient, value + power * coefficient
        if k < len(p) - 1:
            term, power = A * term + C * power, power * M
    return value, total


def _stein(
    A: flint.fmpz_mat, B: flint.fmpz_mat, C: flint.fmpz_mat, p: list[flint.fmpz], step: flint.fmpz
) -> tuple[flint.fmpz_mat, flint.fmpz_mat]:
    """Sum p_k step^k B^(n-k) and p_k T_k B^(n-k), since p(A) X B^n is 0."""
    scales, terms = [flint.fmpz(1)], [C * 0]
    for _ in p[1:]:
        terms.append(A * terms[-1] * B + C * scales[-1])
        scales.append(scales[-1] * step)
    power = B**0
    total, value = C * 0, power * 0
    for coefficient, scale, term in reversed(list(zip(p, scales, terms, strict=True))):
        weighted = power * coefficient
        value, total = value + weighted * scale, total + term * weighted
        power = power * B
    return value, total


def _by_inverse(matrix: flint.fmpz_mat, right: flint.fmpz_mat) -> tuple[flint.fmpz_mat, flint.fmpz]:
    """Return numerators and denominator of right * matrix^-1, by Dixon's lifting modulo a prime.

    Some combinations of the rows are solved for first. Their denominator is that of all rows but
    for small primes, and to know it saves half of the steps and every reconstruction of a fraction.
    Where the product of the result and the matrix shows bad luck, python-flint solves.
    """
    rows, modulo = right.nrows(), 10_007
    weights = [pow(5, k * k + k, modulo) for k in range(_PROBES * rows)]
    combined = flint.fmpz_mat(_PROBES, rows, weights) * right
    turned = flint.fmpq_mat(matrix.transpose())
    probe = turned.solve(flint.fmpq_mat(combined.transpose()), algorithm="dixon")
    numerators, denominator = probe.numer_denom()
    longest = max(abs(int(entry)).bit_length() for entry in [*numerators.entries(), denominator])
    _ask_for_digits(right, 4 * longest, "fifty")  # above and below
    denominator *= _SMALL_PRIMES
    found = _lifted(matrix, right, denominator, longest + _SPARE_BITS)
    if found * matrix == right * denominator:
        return found, denominator
    solution = turned.solve(flint.fmpq_mat(right.transpose()), algorithm="dixon").transpose()
    top, bottom = solution.numer_denom()
    return top, bottom


def _lifted(
    matrix: flint.fmpz_mat, right: flint.fmpz_mat, denominator: flint.fmpz, bits: int
) -> flint.fmpz_mat:
    """Return denominator * right * matrix^-1 if it is integer and of so many bits at most."""
    modulus = flint.fmpz(2**62 - 57)
    while not modulus.is_prime() or flint.nmod_mat(matrix, int(modulus)).det() == 0:
        modulus -= 2
    size = matrix.nrows()
    inverse = flint.nmod_mat(matrix, int(modulus)).inv()
    inverse = flint.fmpz_mat(size, size, [int(x) for x in inverse.entries()])
    for _ in range(_DOUBLINGS):
        modulus *= modulus
        twice = matrix**0 * 2
        inverse = _mod(inverse * (twice - _mod(matrix * inverse, modulus)), modulus)
    digits, rest, whole = [], right, flint.fmpz(1)
    while int(whole).bit_length() < bits:
        digits.append(_mod(rest * inverse, modulus))
        rest = _over(rest - digits[-1] * matrix, modulus)
        whole *= modulus
    while len(digits) > 1:
        pairs = [digits[i : i + 2] for i in range(0, len(digits), 2)]
        digits = [pair[0] + pair[1] * modulus if len(pair) > 1 else pair[0] for pair in pairs]
        modulus *= modulus
    found = _mod(digits[0] * denominator, whole)
    half = whole // 2
    entries = [entry if entry <= half else entry - whole for entry in found.entries()]
    return flint.fmpz_mat(found.nrows(), found.ncols(), entries)


def _mod(matrix: flint.fmpz_mat, modulus: flint.fmpz) -> flint.fmpz_mat:
    entries = [entry % modulus for entry in matrix.entries()]
    return flint.fmpz_mat(matrix.nrows(), matrix.ncols(), entries)


def _over(matrix: flint.fmpz_mat, divisor: flint.fmpz) -> flint.fmpz_mat:
    entries = [entry // divisor for entry in matrix.entries()]
    return flint.fmpz_mat(matrix.nrows(), matrix.ncols(), entries)


def sum_of_products(*products: tuple[Matrix, ...]) -> Matrix:
    """Return a sum of products of matrices, in integers where all of them are rational.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrix_equations.rational_equations import sum_of_products
    >>> A, B = Matrix([[1, 2]]), Matrix([[3], [4]])
    >>> sum_of_products((A, B), (Matrix([[5]]),))
    Matrix([[16]])
    """
    found = [[rational_in_flint(factor) for factor in factors] for factors in products]
    if any(factor is None for factors in found for factor in factors):
        terms = [reduce(mul, factors) for factors in products]
        return reduce(add, terms)
    total, over = None, flint.fmpz(1)
    for factors in found:
        split = [factor.numer_denom() for factor in factors if factor is not None]
        term, divisor = reduce(mul, [n for n, _ in split]), reduce(mul, [d for _, d in split])
        common = over.lcm(divisor)
        term *= common // divisor
        total = term if total is None else total * (common // over) + term
        over = common
    return from_flint(flint.fmpq_mat(total) / over)
