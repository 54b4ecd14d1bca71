"""Conversion of compensators from state space to difference equations, certified."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag
from sympy import Matrix, Symbol

import compensator_theory as exact
from compensator_theory.errors import IllConditionedError
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from rcac_numeric.analysis._state_space import StateSpace
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import matrix
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._compensator import Compensator

# Residual below which smaller coefficients are preferred; residual above which a difference
# equation is refused.
GOOD, ACCEPTED = 1e-11, 1e-9
FURTHER = 2  # steps beyond the shortest difference equation, where its poles are free
CANCELLED = 0.99  # modulus of a pole that cancels


@dataclass(frozen=True, eq=False)
class ConversionCertificate(Result):
    """The comparison of a difference equation with its state space.

    Attributes
    ----------
    points : array of complex
        Where both were evaluated: on the unit circle, at the angles of the poles too, and outside;
        points next to a pole are moved outward.
    residual : float
        Largest distance of the two responses there, relative to the response at the point, or to
        1e-6 of the largest where it is smaller than that.
    pole_residual : float
        Largest relative distance of det D_c to det(qI - A_c) times the factors of the poles that
        cancel, there: no other mode was added but poles at 0.
    left_out : int
        Number of modes of A_c that are unobservable in u and absent from the difference equation.
    cancelled : float
        Largest modulus of the poles of D_c that cancel; 0 where they are at 0.
    """

    points: ComplexArray
    residual: float
    pole_residual: float
    left_out: int
    cancelled: float = 0.0

    @property
    def worst(self) -> float:
        """The larger of the two."""
        return max(self.residual, self.pole_residual)


def compensator_from_state_space(
    A_c: ArrayLike, B_c: ArrayLike, C_c: ArrayLike, D_c: ArrayLike | None = None
) -> Compensator:
    """Return the difference equation (2.28) of a compensator in state space.

    With one output D_c(q) = det(qI - A_c), computed exactly and rounded once. With several, a
    deadbeat observer of the state reads all of them, some, or combinations: of those that
    reproduce the response, the one with the smallest coefficients is taken. What (2.28) has more
    states than A_c are poles at 0, and modes of A_c that u does not show are left out. Where its
    coefficients are too large for float64, as where modes hardly show in u, those
    of least norm are taken: their further poles are inside the circle, and cancel.

    Parameters
    ----------
    A_c, B_c, C_c, D_c : arrays of shape (n_c, n_c), (n_c, l_y), (l_u, n_c), (l_u, l_y)
        D_c is zero by default.

    Returns
    -------
    Compensator
        Of an order of at most n_c, at least 1.

    Raises
    ------
    IllConditionedError
        Where no difference equation with float64 coefficients reproduces the response to 1e-9.

    Examples
    --------
    >>> from rcac_numeric import compensator_from_state_space
    >>> G_c = compensator_from_state_space([[0.5, 1.0], [0.0, 0.2]], [[0.0], [1.0]], [[1.0, 0.0]])
    >>> G_c.denominator, G_c.numerator
    (array([ 1. , -0.7,  0.1]), array([0., 0., 1.]))
    """
    A = matrix(A_c, "A_c", (None, None))
    A = matrix(A, "A_c", (len(A), len(A)))
    B = matrix(B_c, "B_c", (len(A), None))
    C = matrix(C_c, "C_c", (None, len(A)))
    D = np.zeros((len(C), B.shape[1])) if D_c is None else D_c
    return converted((A, B, C, matrix(D, "D_c", (len(C), B.shape[1]))))[0]


def converted(
    parts: StateSpace, accepted: float = ACCEPTED
) -> tuple[Compensator, ConversionCertificate]:
    """Convert with another accuracy, and return the certificate too."""
    points = _check_points(parts[0])
    with np.errstate(all="ignore"):  # overflow is checked below
        response, scales = _response(parts, points)
    if not all(np.isfinite(one).all() for one in (response, *scales)):
        raise IllConditionedError(
            "the response of this compensator overflows float64. Scale its states, and its inputs "
            "and "
            "outputs to similar magnitude."
        )
    best = None
    for scale in scales:
        best = _best(parts, points, (response, scale))
        if best is not None and best[1].worst <= accepted:
            return best
    for scale in scales if len(parts[2]) > 1 else ():
        for equation, basis, further in _of_least_norm(parts):
            both = block_diag(basis.T @ parts[0] @ basis, further)
            certificate = ConversionCertificate(
                points, *_residuals(equation, both, points, (response, scale)),
                len(basis) - basis.shape[1],
                float(np.abs(np.linalg.eigvals(further)).max(initial=0.0)),
            )  # fmt: skip
            if best is None or certificate.worst < best[1].worst:
                best = Compensator(*equation), certificate
            if certificate.worst <= accepted:
                return Compensator(*equation), certificate
    reached = "none is finite" if best is None else f"the best is off by {best[1].worst:.1e}"
    raise IllConditionedError(
        "no difference equation (2.28) with float64 coefficients reproduces this compensator of "
        f"order {len(parts[0])} ({reached}, relative). Keep it in state space, as "
        "(A_c, B_c, C_c, D_c) or a python-control system, or scale its inputs and outputs to like "
        "size."
    )


def _best(
    parts: StateSpace, points: ComplexArray, response: tuple[ComplexArray, Array]
) -> tuple[Compensator, ConversionCertificate] | None:
    best = None
    with np.errstate(all="ignore"):  # an overflow gives an infinite residual
        for (P, Q), basis in _candidates(parts):
            if not (np.isfinite(P).all() and np.isfinite(Q).all()):
                continue
            residuals = _residuals((P, Q), basis.T @ parts[0] @ basis, points, response)
            certificate = ConversionCertificate(points, *residuals, len(parts[0]) - basis.shape[1])
            if best is None or _rank(certificate, P, Q) < _rank(
                best[1], best[0].past_u, best[0].past_y
            ):
                best = Compensator(P, Q), certificate
            if len(parts[2]) == 1 and certificate.worst <= GOOD:
                break  # the exact characteristic polynomial is optimal
    return best


def _rank(certificate: ConversionCertificate, P: Array, Q: Array) -> tuple[float, float]:
    """Return the sort key: coefficients for an accurate conversion, else the residual."""
    size = max(float(np.abs(P).max()), float(np.abs(Q).max()))
    return (0.0, size) if certificate.worst <= GOOD else (certificate.worst, size)


def _candidates(parts: StateSpace) -> Iterator[tuple[Coefficients, Array]]:
    A, B, C, D = parts
    if not (A.size and C.any()):
        constant = np.zeros((1, len(C), len(C))), np.stack([D, np.zeros_like(D)])
        yield constant, np.zeros((len(A), 0))
        return
    if len(C) == 1:
        yield _exactly(A, B, C, D), np.eye(len(A))
    yield from difference_equations(A, B, C, D)
    yield (np.zeros((1, len(C), len(C))), np.stack([D, np.zeros_like(D)])), np.zeros((len(A), 0))


def _check_points(A: Array) -> ComplexArray:
    poles = np.linalg.eigvals(A) if A.size else np.zeros(0)
    omega = np.concatenate([np.linspace(0, np.pi, 33), np.abs(np.angle(poles))])
    points = np.concatenate([np.exp(1j * omega), 1.5 * np.exp(1j * np.array([0.3, 1.1, 2.5]))])
    for _ in range(20):
        near = (np.abs(points[:, None] - poles) < 1e-4 * np.abs(points)[:, None]).any(axis=1)
        points = np.where(near, points * (1 + 1e-3), points)
    return np.asarray(points)


def _response(parts: StateSpace, points: ComplexArray) -> tuple[ComplexArray, list[Array]]:
    """Return G_c at the points, and the magnitudes for relative errors.

    Near a zero the magnitude is bounded below by 1e-6 of the largest value; for a response below
    the rounding of its terms, by their magnitude if requested.
    """
    A, B, C, D = parts
    pencils = points[:, None, None] * np.eye(len(A)) - A
    states = np.linalg.solve(pencils, np.broadcast_to(B, (len(points), *B.shape)))
    response = np.asarray(C @ states + D, dtype=np.complex128)
    scale = np.linalg.norm(response, axis=(1, 2))
    terms = np.linalg.norm(C) * np.linalg.norm(states, axis=(1, 2)) + np.linalg.norm(D)
    scales = [np.maximum(scale, 1e-6 * scale.max())]
    if scale.max() <= 1e-12 * terms.max():
        scales.append(terms)
    return response, [np.where(scale > 0, scale, 1.0) for scale in scales]


def _residuals(
    equation: Coefficients, A: Array, points: ComplexArray, reference: tuple[ComplexArray, Array]
) -> tuple[float, float]:
    """Return the residuals of the response, and of det D_c to det(qI - A)."""
    P, Q = equation
    response, scale = reference
    powers = points[:, None] ** -np.arange(len(Q))
    left = np.eye(len(P[0])) - np.einsum("zi,iab->zab", powers[:, 1:], P)
    right = np.einsum("zi,iab->zab", powers, Q)
    try:
        gap = np.linalg.norm(np.linalg.solve(left, right) - response, axis=(1, 2)) / scale
    except np.linalg.LinAlgError:  # a pole where A has none
        return np.inf, np.inf
    determinants = np.linalg.det(np.eye(len(A)) - A / points[:, None, None])
    poles = np.abs(np.linalg.det(left) / determinants - 1)
    if not (np.isfinite(gap).all() and np.isfinite(poles).all()):
        return np.inf, np.inf
    return float(gap.max()), float(poles.max())


def _exactly(A: Array, B: Array, C: Array, D: Array) -> Coefficients:
    """Return the numerators over det(qI - A), for one output."""
    a, b, c, d = (
        Matrix(*m.shape, [exact.exact_number(float(entry), binary=True) for entry in m.ravel()])
        for m in (A, B, C, D)
    )
    maps = transfer_matrix_of_realisation(a, b, c, d, Symbol("q"))
    n = len(A)
    denominator = maps[0, 0].denominator
    P = [-float(denominator.nth(n - i)) for i in range(1, n + 1)]
    Q = [
        [float(maps[0, column].numerator.nth(n - i)) for column in range(B.shape[1])]
        for i in range(n + 1)
    ]
    return np.array(P)[:, None, None], np.array(Q)[:, None, :]


# Difference equations from state space, by deadbeat observers.

Coefficients = tuple[Array, Array]
# Relative tolerances of the rank; each is tried.
TOLERANCES = (1e-13, 1e-11, 1e-9, 1e-7, 1e-5)


def difference_equations(
    A: Array, B: Array, C: Array, D: Array
) -> Iterator[tuple[Coefficients, Array]]:
    """Yield coefficients (P, Q) of (2.28) and a basis of the retained states.

    With A - F W'C nilpotent, x(k) is a combination of the last few u and y, and so is u(k):

    P_i = C (A - F W'C)^(i-1) F W',  Q_i = C (A - F W'C)^(i-1) (B - F W'D),  Q_0 = D

    Whatever W is, the poles of P are those of A and zeros. Which outputs W'u the observer reads,
    and which singular values count as zero, float64 cannot decide: every choice is returned, and
    the caller compares the responses.
    """
    for W in _readings(C):
        for tolerance in TOLERANCES:
            F, basis, steps = deadbeat_gain(A, W.T @ C, tolerance)
            if not steps:
                continue
            A_reduced, inputs, outputs, gain = (
                basis.T @ A @ basis,
                basis.T @ B,
                C @ basis,
                basis.T @ F @ W.T,
            )
            row, P, Q = outputs, [], [D]
            nilpotent = A_reduced - gain @ outputs
            for _ in range(steps):
                P.append(row @ gain)
                Q.append(row @ (inputs - gain @ D))
                row = row @ nilpotent
            yield (np.array(P), np.array(Q)), basis


def _of_least_norm(parts: StateSpace) -> Iterator[tuple[Coefficients, Array, Array]]:
    """Yield coefficients (P, Q) of (2.28) of least norm, a basis of the retained states, and M_0.

    From x(k-s), without y, [u(k-1); ...; u(k-s)] = O x(k-s) and u(k) = C A^s x(k-s) = P O x(k-s).
    The P of least norm needs neither a small pivot nor modes that hardly show in u, as a deadbeat
    observer does; Q follows from the impulse response. The companion matrix M of P maps the image
    of O to itself, where it has the poles of A; M_0 is M on the complement, whose poles cancel.
    They are inside the circle where s is large enough.

    Source: R. Kumaresan, IEEE Transactions on Acoustics, Speech, and Signal Processing 31 (1983)
    217-220, of the zeros of prediction-error filters of least norm.
    """
    A, B, C, D = parts
    n, m = len(A), len(C)
    sizes = np.linalg.norm(C, axis=1)
    sizes = np.where(sizes > 0, sizes, 1.0)
    shortest = -(-n // m)
    rows = [C]
    while len(rows) <= shortest + FURTHER:
        rows.append(rows[-1] @ A)
    impulse = [D, *(row @ B for row in rows)]
    for steps in range(shortest, shortest + FURTHER + 1):
        past = np.vstack([row / sizes[:, None] for row in reversed(rows[:steps])])
        target = rows[steps] / sizes[:, None]
        if not (np.isfinite(past).all() and np.isfinite(target).all()):
            return
        left, values, right = np.linalg.svd(past)
        ranks = {int((values > tolerance * values[0]).sum()) for tolerance in TOLERANCES}
        for rank in sorted(ranks, reverse=True):
            basis, rest = right[:rank].T, left[:, rank:]
            scaled = target @ basis / values[:rank] @ left[:, :rank].T
            companion = np.vstack([scaled, np.eye((steps - 1) * m, steps * m)])
            further = rest.T @ companion @ rest
            if not np.abs(np.linalg.eigvals(further)).max(initial=0.0) < CANCELLED:
                continue
            P = [one * sizes[:, None] / sizes for one in np.split(scaled, steps, axis=1)]
            Q = [
                impulse[k] - sum((P[i - 1] @ impulse[k - i] for i in range(1, k + 1)), 0.0 * D)
                for k in range(steps + 1)
            ]
            yield (np.array(P), np.array(Q)), basis, further


def deadbeat_gain(A: Array, C: Array, tolerance: float) -> tuple[Array, Array, int]:
    """Return F with A - FC nilpotent on the observable modes, a basis, and the number of steps.

    Of the dual pair (A', C') the states that a control brings to zero in k steps make up S_k,

    S_(k+1) = {x : A'x in S_k + im C'},

    and a feedback with (A' - C'F') S_(k+1) in S_k is one least-squares problem for each k, in
    orthonormal bases throughout. The chain ends before it spans everything where modes do not
    show in C.
    """
    n = len(A)
    sizes = np.linalg.norm(C, axis=1)
    sizes = np.where(sizes > 0, sizes, 1.0)
    inputs = (C / sizes[:, None]).T
    size = float(np.linalg.norm(A, 2)) or 1.0
    reached, feedback, steps = np.zeros((n, 0)), np.zeros((len(C), 0)), 0
    while reached.shape[1] < n:
        rest = np.linalg.qr(reached, mode="complete")[0][:, reached.shape[1] :]
        outside = rest @ _complement(rest.T @ inputs, tolerance)
        _, values, right = np.linalg.svd(outside.T @ A.T @ rest / size)
        new = rest @ right[int((values > tolerance).sum()) :].T
        if not new.shape[1]:
            break
        beyond = np.eye(n) - reached @ reached.T
        moves = np.linalg.lstsq(beyond @ inputs, -beyond @ A.T @ new, rcond=tolerance)[0]
        feedback, reached = np.hstack([feedback, moves]), np.hstack([reached, new])
        steps += 1
    return -(feedback @ reached.T / sizes[:, None]).T, reached, steps


def _readings(C: Array) -> Iterator[Array]:
    """Yield combinations W'u of the outputs: all, the strongest few, each alone, all but one."""
    count = len(C)
    sizes = np.linalg.norm(C, axis=1, keepdims=True)
    strongest = np.linalg.svd(C / np.where(sizes > 0, sizes, 1.0))[0]
    yield np.eye(count)
    for rank in range(1, count):
        yield strongest[:, :rank]
    if count > 1:
        yield from (np.eye(count)[:, [i]] for i in range(count))
    if count > 2:
        yield from (np.delete(np.eye(count), i, axis=1) for i in range(count))


def _complement(columns: Array, tolerance: float) -> Array:
    """Return an orthonormal basis of the complement of the columns, which have length 1 at most."""
    left, values, _ = np.linalg.svd(columns)
    rank = int((values > tolerance).sum())
    return np.asarray(left[:, rank:])
