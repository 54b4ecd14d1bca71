"""The limit of predictive cost adaptive control: a finite-horizon gain on a deadbeat observer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.matrices._certificates import Certified, Residuals
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import (
    identity_matrix,
    is_rational_matrix,
    zero_matrix,
)
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    in_lowest_terms,
    multiplied,
    solve,
)
from compensator_theory.polynomials._budget import ask, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._substitution import denominators_in
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, require_discrete
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._transfer_functions import TransferFunction

Coefficients: TypeAlias = Sequence[NumberLike | MatrixLike]
WeightLike: TypeAlias = NumberLike | MatrixLike


@dataclass(frozen=True)
class PredictiveCostCompensator(Certified, ExactValue):
    r"""The compensator of predictive cost adaptive control for a constant model and gain.

    .. math:: \hat x(k+1) = A\hat x(k) + \Gamma u(k) + \Phi\,(y(k) - C\hat x(k)),
        \qquad u(k) = K\hat x(k) + K_u u(k-1)

    A is in block observable form with the first block column Phi, so that A - Phi C is nilpotent:
    a deadbeat observer.

    Attributes
    ----------
    model : Realisation
        (A, Gamma, C), of order n p for n lags and p outputs.
    K : sympy.ImmutableMatrix
        m x np.
    K_u : sympy.ImmutableMatrix or None
        m x m, where the cost weighs the moves u(k) - u(k-1); None where it weighs u.
    regulator : sympy.Poly
        det(qI - A - Gamma K); with K_u that of the states x(k) and u(k-1).
    gains : tuple of sympy.ImmutableMatrix
        The gains of the finite-horizon problem from its first step on; empty for a given K.
    Q, P, R : sympy.ImmutableMatrix or None
        Its weights; None for a given K.

    Notes
    -----
    Source: T.-W. Nguyen, S. A. U. Islam, D. S. Bernstein and I. V. Kolmanovsky, IEEE Control Syst.
    Mag. 41 (2021) 64-96; the theorem `predictive-control-limit` of the ledger of proofs.
    """

    _CARRIES = True
    identity = (
        "T A~ = A' T with the blocks regulator and deadbeat observer; the gains make the "
        "finite-horizon cost stationary"
    )

    model: Realisation
    K: ImmutableMatrix
    K_u: ImmutableMatrix | None
    regulator: Poly
    gains: tuple[ImmutableMatrix, ...] = ()
    Q: ImmutableMatrix | None = None
    P: ImmutableMatrix | None = None
    R: ImmutableMatrix | None = None

    @property
    def Phi(self) -> ImmutableMatrix:
        """The observer gain, np x p: the coefficients of the past outputs, one below the other."""
        return ImmutableMatrix(self.model.A[:, : self.model.C.rows])

    @property
    def compensator(self) -> Realisation:
        """The strictly proper compensator from y to u, positive feedback."""
        model, Phi = self.model, self.Phi
        observer = model.A - multiplied(Phi, model.C)
        K, K_u, size = self.K, self.K_u, model.B.cols
        A_c, B_c, C_c = observer + multiplied(model.B, K), Phi, K
        if K_u is not None:
            A_c = A_c.row_join(multiplied(model.B, K_u)).col_join(K.row_join(K_u))
            B_c, C_c = Phi.col_join(zero_matrix(size, Phi.cols)), K.row_join(K_u)
        return Realisation(
            in_lowest_terms(A_c), B_c, C_c, None, model.variable, sample_time=model.sample_time
        )

    @property
    def transfer_function(self) -> TransferFunction:
        """G_c of u = G_c y, for one input and one output."""
        return self.compensator.transfer_function()

    @property
    def characteristic_polynomial(self) -> Poly:
        """The polynomial of the loop: `regulator` times q to the power np."""
        q = self.model.variable
        return canonical(self.regulator * Poly(q**self.model.n, q))

    def _residuals(self) -> Residuals:
        """Return the residuals of the similarity, the polynomials and the optimality."""
        model, q = self.model, self.model.variable
        n, m = model.n, model.B.cols
        observer = in_lowest_terms(model.A - multiplied(self.Phi, model.C))
        inner = in_lowest_terms(_regulated(model, self.K, self.K_u))
        moved = multiplied(model.B, self.K)
        if self.K_u is not None:
            moved = moved.col_join(self.K)
        below = zero_matrix(n, inner.rows).row_join(observer)
        separated = inner.row_join(-moved).col_join(below)
        identity, zero = identity_matrix(n), zero_matrix
        extra = 0 if self.K_u is None else m
        rows = [identity.row_join(zero(n, n + extra))]
        if extra:
            rows.append(zero(m, 2 * n).row_join(identity_matrix(m)))
        rows.append(identity.row_join(-identity).row_join(zero(n, extra)))
        T = rows[0]
        for row in rows[1:]:
            T = T.col_join(row)
        loop = in_lowest_terms(closed_loop_matrix(model, self.compensator))
        yield multiplied(T, loop) - multiplied(separated, T)
        yield (characteristic_polynomial(inner, q) - self.regulator).all_coeffs()
        yield (characteristic_polynomial(observer, q) - Poly(q**n, q)).all_coeffs()
        if self.gains:
            yield from self._stationarity()

    def _stationarity(self) -> Residuals:
        """Return the derivatives of the cost in every control, by the adjoint equation.

        x(j+1) = (A + B K_j) x(j), lambda(l) = C'PC x(l), lambda(j) = C'QC x(j) + A'lambda(j+1),
        0 = R v(j) + B'lambda(j+1) for every x(0); `gains` enter, the Riccati matrices do not.
        """
        assert self.Q is not None and self.P is not None and self.R is not None
        A, B, C = _predicted(self.model, self.K_u is not None)
        states = [identity_matrix(A.rows)]
        for gain in self.gains:
            states.append(in_lowest_terms(multiplied(A + multiplied(B, gain), states[-1])))
        adjoint = multiplied(C.T, self.P, C, states[-1])
        for gain, state in zip(reversed(self.gains), reversed(states[:-1]), strict=True):
            yield in_lowest_terms(multiplied(self.R, gain, state) + multiplied(B.T, adjoint))
            adjoint = in_lowest_terms(multiplied(C.T, self.Q, C, state) + multiplied(A.T, adjoint))
        first = self.K if self.K_u is None else self._move_gain()
        yield self.gains[0] - first

    def _move_gain(self) -> ImmutableMatrix:
        """Return the gain of the move u(k) - u(k-1)."""
        assert self.K_u is not None
        return ImmutableMatrix(self.K.row_join(self.K_u - identity_matrix(self.K_u.rows)))

    def __str__(self) -> str:
        more = "" if self.K_u is None else f", K_u = {text(self.K_u.tolist())}"
        n, q = self.model.n, self.model.variable
        return (
            f"K = {text(self.K.tolist())}{more}: regulator {format_polynomial(self.regulator)}\n"
            f"deadbeat observer {q}**{n}"
        )

    def _repr_latex_(self) -> str:
        gains = [f"K = {latex(self.K)}"]
        if self.K_u is not None:
            gains.append(f"K_u = {latex(self.K_u)}")
        q, n = latex(self.model.variable), self.model.n
        return displayed(*gains, rf"\tilde D = {q}^{{{n}}}\left({latex(self.regulator)}\right)")


@carrying()
def predictive_cost_compensator(
    model: TransferFunctionLike | tuple[Coefficients, Coefficients],
    K: MatrixLike | None = None,
    *,
    horizon: int | None = None,
    Q: WeightLike = 1,
    P: WeightLike = 1,
    R: WeightLike = 1,
    weighs: Literal["moves", "u"] = "moves",
    variable: str | Symbol | None = None,
) -> PredictiveCostCompensator:
    r"""Return the compensator of predictive cost adaptive control for a model that stays.

    The loop of the model with it has the polynomial :math:`q^{np}\det(qI - A - \Gamma K)`, for
    every model and every gain: the limit of predictive cost adaptive control is an observer-based
    compensator with a deadbeat observer.

    Parameters
    ----------
    model : transfer function in q or z, or a pair (b, a)
        :math:`y(k) = \sum_i a_i y(k-i) + \sum_i b_i u(k-i)`, i = 1, ..., n; for several signals the
        coefficients are matrices, p x m and p x p. Symbols allowed. A transfer function is in
        lowest terms; a pair keeps common factors.
    K : matrix, optional
        m x np, for u = K x^; or m x (np + m), [K, K_u]. In place of a horizon.
    horizon : int, optional
        l, the number of controls in the cost

        .. math:: \sum_{j=0}^{l-1}\left(y_j^T Q y_j + v_j^T R v_j\right) + y_l^T P y_l
    Q, P, R : number or matrix
        Weights; R definite, the others semidefinite. A number is a multiple of I.
    weighs : {"moves", "u"}
        What v is: u(j) - u(j-1), or u(j).
    variable : str or Symbol, optional
        Of a pair; q by default.

    Raises
    ------
    InputError
        If the model is not in discrete time, sizes do not fit, a weight is not definite, or both
        or none of K and horizon are given.
    ImproperError
        If the transfer function is not strictly proper.

    Notes
    -----
    Source: the theorem `predictive-control-limit` of the ledger of proofs, checked in Coq for any
    numbers of signals; finite-horizon Riccati recursion.

    Examples
    --------
    With symbols, for every model of order 1 and every gain:

    >>> from compensator_theory import predictive_cost_compensator
    >>> limit = predictive_cost_compensator((["b"], ["a"]), [["K"]])
    >>> limit.characteristic_polynomial.as_expr()
    q**2 + q*(-K*b - a)

    The gain of a horizon, and what becomes of an unstable nonminimum-phase plant:

    >>> G = "(q - 13/10)/(q**2 - 7/5*q + 3/10)"
    >>> limit = predictive_cost_compensator(G, horizon=2, Q=2, P=5, weighs="u")
    >>> print(limit)
    K = [[-1763/1805, -254/361]]: regulator q**2 - 483*q/361 + 36/361
    deadbeat observer q**2
    >>> limit.certificate.holds
    True
    """
    system = _read_model(model, variable)
    n, m = system.n, system.B.cols
    if (K is None) == (horizon is None):
        raise InputError("give the gain K or the horizon of a cost, and not both")
    if K is not None:
        gain = exact_matrix(K, "K")
        if gain.shape not in ((m, n), (m, n + m)):
            raise InputError(
                f"K is {gain.rows} x {gain.cols}; {m} x {n} is needed, or {m} x {n + m} for "
                "[K, K_u]"
            )
        K_u = gain[:, n:] if gain.cols > n else None
        return _joined(system, ImmutableMatrix(gain[:, :n]), K_u)
    if isinstance(horizon, bool) or not isinstance(horizon, int) or horizon < 1:
        raise InputError(f"horizon = {repr_of(horizon)} must be an integer of at least 1")
    if not isinstance(weighs, str) or weighs not in ("moves", "u"):
        raise InputError(f"weighs = {repr_of(weighs)} is not known; use 'moves' or 'u'")
    ask("entries", horizon * (n + m) ** 2, "the finite-horizon problem")
    p = system.C.rows
    sizes = {"Q": (Q, p, False), "P": (P, p, False), "R": (R, m, True)}
    weights = {name: _weight(*value, name) for name, value in sizes.items()}
    gains = _finite_horizon_gains(*_predicted(system, weighs == "moves"), **weights, steps=horizon)
    first = gains[0]
    K_u = None
    if weighs == "moves":
        K_u = ImmutableMatrix(first[:, n:] + identity_matrix(m))
    return _joined(system, ImmutableMatrix(first[:, :n]), K_u, gains, **weights)


@generic_answer_of(predictive_cost_compensator)
def _generic_limit(
    model: Any, *arguments: Any, **options: Any
) -> tuple[PredictiveCostCompensator, list[Expr]]:
    """Return the compensator and its condition: no denominator vanishes."""
    limit = predictive_cost_compensator(model, *arguments, **options)
    return limit, [*denominators_in(limit)]


def _joined(
    system: Realisation,
    K: ImmutableMatrix,
    K_u: ImmutableMatrix | None,
    gains: Sequence[ImmutableMatrix] = (),
    **weights: ImmutableMatrix,
) -> PredictiveCostCompensator:
    inner = in_lowest_terms(_regulated(system, K, K_u))
    regulator = characteristic_polynomial(inner, system.variable)
    return PredictiveCostCompensator(system, K, K_u, regulator, tuple(gains), **weights)


def _regulated(
    model: Realisation, K: ImmutableMatrix, K_u: ImmutableMatrix | None
) -> ImmutableMatrix:
    """Return the matrix of the states x(k), and u(k-1), under the state feedback."""
    inner = model.A + multiplied(model.B, K)
    if K_u is None:
        return ImmutableMatrix(inner)
    return ImmutableMatrix(inner.row_join(multiplied(model.B, K_u)).col_join(K.row_join(K_u)))


def _predicted(
    model: Realisation, moves: bool
) -> tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]:
    """Return (A, B, C) of the prediction; for moves with the state [x(k); u(k-1)]."""
    A, B, C, n, m = model.A, model.B, model.C, model.n, model.B.cols
    if not moves:
        return A, B, C
    identity = identity_matrix(m)
    A_m = A.row_join(B).col_join(zero_matrix(m, n).row_join(identity))
    return (
        ImmutableMatrix(A_m),
        ImmutableMatrix(B.col_join(identity)),
        ImmutableMatrix(C.row_join(zero_matrix(C.rows, m))),
    )


def _finite_horizon_gains(
    A: ImmutableMatrix,
    B: ImmutableMatrix,
    C: ImmutableMatrix,
    *,
    Q: ImmutableMatrix,
    P: ImmutableMatrix,
    R: ImmutableMatrix,
    steps: int,
) -> list[ImmutableMatrix]:
    """Return the gains of the backward Riccati recursion, that of the first step first."""
    S, running, gains = multiplied(C.T, P, C), multiplied(C.T, Q, C), []
    for _ in range(steps):
        moved = multiplied(B.T, S)
        try:
            gain = -solve(
                in_lowest_terms(R + multiplied(moved, B)), in_lowest_terms(multiplied(moved, A))
            )
        except NoSolutionError as error:
            raise InputError(
                "R + B'SB is singular, so that the cost has no unique minimum; choose a definite R"
            ) from error
        gains.append(ImmutableMatrix(gain))
        S = in_lowest_terms(running + multiplied(A.T, S, A + multiplied(B, gain)))
    return gains[::-1]


def _read_model(
    model: TransferFunctionLike | tuple[Coefficients, Coefficients], variable: str | Symbol | None
) -> Realisation:
    """Return the block observable form of a transfer function or of (b, a)."""
    if isinstance(model, tuple) and len(model) == 2:
        q = as_symbol("q" if variable is None else variable)
        require_discrete(q, "predictive cost adaptive control")
        b, a = (_blocks(cast("Any", part), name) for part, name in zip(model, "ba", strict=True))
        return _block_observable_form(b, a, q)
    G = transfer_function(cast("TransferFunctionLike", model), variable)
    require_discrete(G.variable, "predictive cost adaptive control")
    if not G.is_strictly_proper:
        raise ImproperError("the model has a direct feedthrough; add a delay of one step")
    D = G.denominator.monic()
    N, n = G.numerator.quo_ground(G.denominator.LC()), D.degree()
    a, b = ([exact_matrix([[sign * S.nth(n - i)]], "model") for i in range(1, n + 1)]
            for sign, S in ((-1, D), (1, N)))  # fmt: skip
    form = _block_observable_form(b, a, G.variable)
    return Realisation(form.A, form.B, form.C, None, G.variable, sample_time=G.sample_time)


def _blocks(coefficients: Coefficients, name: str) -> list[ImmutableMatrix]:
    """Return coefficients, numbers or matrices, as matrices."""
    if isinstance(coefficients, str) or not hasattr(coefficients, "__len__"):
        raise InputError(f"{name} = {repr_of(coefficients)} must be a list of coefficients")
    return [_block(entry, name) for entry in coefficients]


def _block(entry: Any, name: str) -> ImmutableMatrix:
    is_matrix = hasattr(entry, "__len__") and not isinstance(entry, str)
    return exact_matrix(entry if is_matrix else [[entry]], name)


def _block_observable_form(
    b: list[ImmutableMatrix], a: list[ImmutableMatrix], variable: Symbol
) -> Realisation:
    n = len(a)
    if n == 0 or len(b) != n:
        raise InputError(
            f"there are {len(b)} coefficients b and {n} coefficients a; an equal number, at least "
            "one, is needed. Fill up with zeros"
        )
    p, m = b[0].shape
    for name, blocks, shape in (("b", b, (p, m)), ("a", a, (p, p))):
        for i, block in enumerate(blocks, 1):
            if block.shape != shape:
                raise InputError(
                    f"{name}_{i} is {block.rows} x {block.cols}; {shape[0]} x {shape[1]} is needed"
                )
    Phi, Gamma = a[0], b[0]
    for i in range(1, n):
        Phi, Gamma = Phi.col_join(a[i]), Gamma.col_join(b[i])
    A = Phi
    if n > 1:
        shift = identity_matrix((n - 1) * p).col_join(zero_matrix(p, (n - 1) * p))
        A = Phi.row_join(shift)
    C = identity_matrix(p)
    if n > 1:
        C = C.row_join(zero_matrix(p, (n - 1) * p))
    return Realisation(A, Gamma, C, None, variable)


def _weight(value: Any, size: int, definite: bool, name: str) -> ImmutableMatrix:
    """Return a weight as a symmetric matrix; where it has no symbols, checked for its sign."""
    read = _block(value, name)
    if read.shape == (1, 1) and size != 1:
        read = ImmutableMatrix(read[0, 0] * identity_matrix(size))
    if read.shape != (size, size):
        raise InputError(f"{name} is {read.rows} x {read.cols}; {size} x {size} is needed")
    if not (read - read.T).is_zero_matrix:
        raise InputError(f"{name} is not symmetric; use ({name} + {name}')/2")
    if is_rational_matrix(read):
        plain = ImmutableMatrix(read.tolist())
        fits = plain.is_positive_definite if definite else plain.is_positive_semidefinite
        if not fits:
            kind = "definite" if definite else "semidefinite"
            raise InputError(f"{name} = {text(read.tolist())} must be positive {kind}")
    return ImmutableMatrix(read) if not is_rational_matrix(read) else read
