"""Observer-based forms of a compensator in float64, vectorised, with residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sympy import ImmutableMatrix

from compensator_theory import InputError, Realisation, closed_loop_matrix, figures, realisation
from compensator_theory.errors import NoSolutionError
from compensator_theory.loops._siso import agreed_sign
from compensator_theory.matrices._invariant_subspaces import derogatory_factor
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.observers import count_observer_forms
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.roots._certified import root_balls
from rcac_numeric.analysis._loop_analysis import closed_loop
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._balancing import balancing_scales, scaled_states
from rcac_numeric.arrays._validation import integer, number
from rcac_numeric.arrays._values import Result
from rcac_numeric.arrays._wording import matrix_latex
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._linear import Plant

# Largest relative residual of a returned form.
RESOLVED = 1e-6
SHOWN = 6  # largest number of forms in a notebook formula


@dataclass(frozen=True, eq=False)
class NumericObserverForm(Result):
    r"""One observer-based form of a compensator in float64.

    .. math:: T^{-1} A_c T = A + BK - FC, \qquad T^{-1} B_c = F, \qquad C_c T = K

    Attributes
    ----------
    T, K : array
        n_c x n and l_u x n.
    F : array or None
        n x l_y; None unless n_c = n.
    regulator_roots, observer_roots : array of complex
        n and n_c.
    residual : float
        Relative, as in :class:`NumericObserverForms`.
    condition : float
        2-norm condition number of T.
    """

    T: Array
    K: Array
    F: Array | None
    regulator_roots: ComplexArray
    observer_roots: ComplexArray
    residual: float
    condition: float


@dataclass(frozen=True, eq=False)
class NumericObserverForms(Result):
    r"""Observer-based forms of a compensator, one in each slice of the arrays.

    .. math:: T^{-1} A_c T = A + BK - FC, \qquad T^{-1} B_c = F, \qquad C_c T = K

    Attributes
    ----------
    plant, compensator : Realisation
        Exact, of orders n and :math:`n_c`.
    T : array
        forms x n_c x n.
    K : array
        forms x l_u x n.
    F : array or None
        forms x n x l_y; None unless n_c = n.
    regulator_roots, observer_roots : array of complex
        forms x n and forms x n_c.
    residual : array
        For each form :math:`\|B_cC + A_cT - T(A + BC_cT)\|_F` over the sum of the norms of the
        terms, with the states of the loop balanced.
    condition : array
        2-norm condition number of T; for :math:`n_c \ne n` of its rectangular shape.
    rejected : int
        Number of subspaces without a form: the basis of their plant part, or T, is numerically
        singular.
    unresolved_roots : array of complex
        Regulator roots, subspaces x n, of the forms that float64 does not resolve: T is singular
        to working precision, or the residual is above 1e-6. `compensator_theory.observer_forms`
        has them where they are rational.
    """

    plant: Realisation
    compensator: Realisation
    T: Array
    K: Array
    F: Array | None
    regulator_roots: ComplexArray
    observer_roots: ComplexArray
    residual: Array
    condition: Array
    rejected: int
    unresolved_roots: ComplexArray

    def __len__(self) -> int:
        return int(self.T.shape[0])

    @property
    def forms(self) -> tuple[NumericObserverForm, ...]:
        """The forms as separate objects."""
        return tuple(map(self._form, range(len(self))))

    def _form(self, i: int) -> NumericObserverForm:
        return NumericObserverForm(
            self.T[i], self.K[i], None if self.F is None else self.F[i], self.regulator_roots[i],
            self.observer_roots[i], float(self.residual[i]), float(self.condition[i]),
        )  # fmt: skip

    def fastest_observer(self) -> NumericObserverForm:
        """Return the form whose slowest observer root is fastest.

        Slow is a large real part, and in the variables z and q a large modulus.
        """
        is_discrete = self.plant.variable.name in ("z", "q")
        speed = np.abs(self.observer_roots) if is_discrete else self.observer_roots.real
        return self._least(speed.max(axis=1, initial=-np.inf))

    def best_conditioned(self) -> NumericObserverForm:
        """Return the form with the least condition number of T."""
        return self._least(self.condition)

    def closest_to(self, K: Any, F: Any) -> NumericObserverForm:
        r"""Return the form that minimises :math:`\|K-K_0\|_F^2 + \|F-F_0\|_F^2`.

        Parameters
        ----------
        K, F : array
            The gains :math:`K_0` (l_u x n) and :math:`F_0` (n x l_y), as in A + BK and A - FC.

        Raises
        ------
        InputError
            If n_c differs from n, or the shapes do not fit.
        NoSolutionError
            If there is no form.
        """
        requested_K, requested_F = np.asarray(K, float), np.asarray(F, float)
        if self.F is None or (requested_K.shape, requested_F.shape) != (
            self.K.shape[1:],
            self.F.shape[1:],
        ):
            raise InputError(
                f"K and F have shapes {requested_K.shape} and {requested_F.shape}; full-order "
                "forms have "
                f"{self.K.shape[1:]} and {None if self.F is None else self.F.shape[1:]}"
            )
        off = [
            ((mine - theirs) ** 2).sum(axis=(1, 2))
            for mine, theirs in ((self.K, requested_K), (self.F, requested_F))
        ]
        return self._least(off[0] + off[1])

    def plot(self) -> figures.Figure:
        """Plot the closed-loop roots, divided into regulator and observer roots for each form."""
        from rcac_numeric.plots._observer_forms import plot_observer_forms

        return plot_observer_forms(self)

    def _repr_latex_(self) -> str:
        forms = []
        for i in range(min(len(self), SHOWN)):
            gains = rf"K_{{{i + 1}}} &= {matrix_latex(self.K[i])}"
            if self.F is not None:
                gains += rf", & F_{{{i + 1}}} &= {matrix_latex(self.F[i])}"
            forms.append(gains)
        more = rf"\text{{{len(self)} forms}}" if len(self) != len(forms) else ""
        body = r" \\ ".join([*forms, *filter(None, [more])]) or r"\text{no form}"
        return rf"$\displaystyle \begin{{aligned}}{body}\end{{aligned}}$"

    def _least(self, cost: Array) -> NumericObserverForm:
        if not len(self):
            raise NoSolutionError("no observer-based form exists; see rejected")
        return self._form(int(np.argmin(cost)))

    @property
    def _unresolved(self) -> str:
        count = len(self.unresolved_roots)
        return f", {count} unresolved in float64 (unresolved_roots)" if count else ""

    def __str__(self) -> str:
        if not len(self):
            return f"no observer-based form; {self.rejected} subspaces rejected{self._unresolved}"
        ordered = np.sort(self.condition)  # not the mean of two: entries may be infinite
        low, middle, high = ordered[0], ordered[len(ordered) // 2], ordered[-1]
        return (
            f"{len(self)} observer-based forms, {self.rejected} subspaces without one"
            f"{self._unresolved}; "
            f"cond(T) {low:.2g} / {middle:.2g} / {high:.2g} (least / median / largest), "
            f"largest residual {self.residual.max():.1e}"
        )


def observer_forms(
    plant: Any, compensator: Any = None, *, feedback: int | None = None, limit: int = 200_000,
    variable: str | None = None, singular: float = 1e-13,
) -> NumericObserverForms:  # fmt: skip
    r"""Compute every real observer-based form, irrational regulator polynomials included.

    .. math:: \mathrm{im}\begin{bmatrix} I \\ T \end{bmatrix} = \ker p_R(\tilde A)

    Parameters
    ----------
    plant : Run, Plant or realisation
        A run has its compensator: its last controller. A realisation is anything that
        :func:`compensator_theory.realisation` reads, rational: ``Realisation(A, B, C, D, "s")``, a
        transfer function, a python-control system. Floats mean their shortest decimals.
    compensator : Compensator or realisation
        :math:`u = C_c x_c`.
    feedback : {+1, -1}, optional
        The sign f in :math:`u = f C_c x_c`; default +1, and the only one of a run and of a
        Compensator. With -1 the compensator of the result has the sign in its output matrix.
    limit : int
        Largest number of forms.
    variable : str, optional
        Of both; default: evident, bare matrices need it.
    singular : float
        A subspace counts as without a form if one of its directions makes an angle with the states
        of the plant, or with those of the compensator, whose sine is not larger. The exact
        decision, :func:`compensator_theory.observers.realisation_is_observer_based`, needs no such
        bound.

    Returns
    -------
    NumericObserverForms
        One form for each real monic divisor :math:`p_R` of degree n that gives one, with residual
        and condition number. Multiplicities are exact: they are taken from the exact characteristic
        polynomial, and a root of multiplicity m contributes the kernels of
        :math:`(\tilde A - \lambda)^e`, e = 0, ..., m, instead of eigenvectors.

    Raises
    ------
    InputError
        If data are symbolic, do not fit, exceed `limit`, or if the closed loop is derogatory, so
        that the forms make up a continuum: :func:`compensator_theory.observer_forms` has it.

    Notes
    -----
    :func:`compensator_theory.observer_forms` has the forms of rational regulator polynomials
    exactly, and those of a continuum.

    Source: (7.11)-(7.18); bases by the SVD.

    Examples
    --------
    >>> from rcac_numeric import observer_forms
    >>> forms = observer_forms("1/s**2", "-(4*s + 2)/(s**2 + 4*s + 5)")
    >>> len(forms), bool(forms.residual.max() < 1e-12)  # s**4 + 4*s**3 + 5*s**2 + 4*s + 2
    (2, True)
    """
    integer(limit, "limit", at_least=1)
    if not 0 < number(singular, "singular") < 1:
        raise InputError(f"singular = {singular} must lie between 0 and 1")
    if isinstance(plant, Run) or isinstance(compensator, Compensator):
        if feedback not in (None, 1):
            raise InputError(
                f"feedback = {feedback!r}: a run and a Compensator compute u = G_c y, which is "
                "feedback = +1; leave feedback out, or change the sign of past_y."
            )
        feedback = None
    if isinstance(plant, Run):
        if compensator is not None:
            raise InputError("a run contains its controller; leave compensator out")
        of_run = closed_loop(plant)
        plant, compensator = of_run.plant, of_run.compensator
    if compensator is None:
        raise InputError("a loop needs a controller; give the compensator, or a Run")
    system, realised = _realisation(plant, variable), _realisation(compensator, variable)
    controller = realised.with_sign(agreed_sign(realised, feedback))
    exact_loop = closed_loop_matrix(system, controller)
    n, n_c = system.n, controller.n
    if not (n and n_c):
        raise InputError(
            f"the plant has {n} and the compensator {n_c} states; both need at least one"
        )
    Dtilde = characteristic_polynomial(exact_loop, system.variable)
    count = count_observer_forms(Dtilde, n)
    if count > limit:
        raise InputError(f"there are {count} candidates, more than limit = {limit}; increase limit")
    if repeated := derogatory_factor(exact_loop, Dtilde):
        raise InputError(
            f"the closed loop has several Jordan blocks for the roots of {repeated.as_expr()}, so "
            "that its forms make up a continuum; compensator_theory.observer_forms parametrises it"
        )
    rounded = _rounded(exact_loop)
    scale = balancing_scales(rounded)
    loop = scaled_states(rounded, scale)
    columns, roots, choices = kernel_bases(loop, rounded_roots(Dtilde))
    regulator, observer = selections(choices, n, n_c)
    V = np.linalg.qr(np.moveaxis(columns[:, regulator], 1, 0)).Q  # forms x (n + n_c) x n
    V_1, V_2 = V[:, :n, :], V[:, n:, :]
    admissible = np.flatnonzero((least_sines(V_1) > singular) & (least_sines(V_2) > singular))
    # T of the balanced loop, and from it T itself: powers of two, so that nothing is rounded.
    T = solved(V_1[admissible].transpose(0, 2, 1), V_2[admissible].transpose(0, 2, 1)).transpose(
        0, 2, 1
    )
    plant_scale, other = scale[:n], scale[n:]
    B_c, C_c = _rounded(controller.B), _rounded(controller.C)
    F = None
    if n == n_c:
        inputs = np.broadcast_to(B_c / other[:, None], (len(T), *B_c.shape))
        F = plant_scale[:, None] * solved(T, inputs)
    left = loop[n:, :n] + loop[n:, n:] @ T
    drift, fed_back = T @ loop[:n, :n], T @ loop[:n, n:] @ T  # both are large where A + BK = 0
    right = drift + fed_back
    terms = np.linalg.norm(loop[n:, :n]) + norms(loop[n:, n:] @ T) + norms(drift) + norms(fed_back)
    T = other[:, None] * T / plant_scale
    residual = norms(left - right) / np.where(terms > 0, terms, 1.0)
    with np.errstate(all="ignore"):
        good = (residual <= RESOLVED) & np.isfinite(T).all(axis=(1, 2))
        if F is not None:
            size = np.linalg.norm(B_c) + norms(T) * norms(F)
            off = norms(T @ F - B_c) / np.where(size > 0, size, 1.0)
            good &= np.isfinite(F).all(axis=(1, 2)) & (off <= RESOLVED)
    which = admissible[good]
    return NumericObserverForms(
        system, controller, T[good], C_c @ T[good], None if F is None else F[good],
        roots[regulator[which]], roots[observer[which]],
        residual[good], np.linalg.cond(T[good]) if len(which) else np.zeros(0),
        len(V) - len(admissible), roots[regulator[admissible[~good]]],
    )  # fmt: skip


def _realisation(system: Any, variable: str | None) -> Realisation:
    """Return the realisation of a plant, a compensator or another system, in q."""
    if isinstance(system, Plant):
        return realisation((system.A, system.B, system.C, system.D_0), "q")
    if isinstance(system, Compensator):
        return realisation(system.state_space(), "q")
    return realisation(system, variable)


def _rounded(matrix: ImmutableMatrix) -> Array:
    try:
        entries = [int(entry.p) / int(entry.q) for entry in matrix]
    except OverflowError:
        raise InputError("an entry of the closed loop is beyond the range of float64") from None
    return np.array(entries, float).reshape(matrix.shape)


# Invariant subspaces of a closed loop in float64, and their enumeration.

# For one root: the columns of the regulator, and the remaining columns of the observer.
Choice = list[tuple[list[int], list[int]]]


def rounded_roots(Dtilde: Any) -> list[tuple[complex, int]]:
    """Return real roots and those of the upper half plane, correctly rounded, with multiplicity."""
    roots = []
    with ball_precision(128):
        for ball, multiplicity in root_balls(Dtilde, 128):
            if ball.imag == 0:
                roots.append((complex(float(ball.real.mid()), 0.0), multiplicity))
            elif ball.imag > 0:
                roots.append((complex(ball.real.mid(), ball.imag.mid()), multiplicity))
    return roots


def kernel_bases(
    loop: Array, roots: list[tuple[complex, int]]
) -> tuple[Array, ComplexArray, list[Choice]]:
    """Return columns that span the kernels, the root of each, and the choices per root.

    A choice is a pair of lists of columns: those of the kernel of the power e for the regulator,
    and as many others as are left for the observer (of these only the roots matter).
    """
    columns: list[Array] = []
    values: list[complex] = []
    choices: list[Choice] = []
    for root, multiplicity in roots:
        is_real = root.imag == 0
        shifted = loop - (root.real if is_real else root) * np.eye(len(loop))
        degree = 1 if is_real else 2
        powers: list[list[int]] = [[]]
        for exponent in range(1, multiplicity + 1):
            rows = np.linalg.svd(np.linalg.matrix_power(shifted, exponent))[2]
            basis = rows[len(loop) - exponent :].conj().T
            real = basis if is_real else np.hstack([basis.real, basis.imag])
            powers.append(list(range(len(values), len(values) + degree * exponent)))
            columns.append(real)
            values += [root, root.conjugate()] * exponent if degree == 2 else [root] * exponent
        whole = powers[-1]
        choices.append([(power, whole[len(power) :]) for power in powers])
    return np.hstack(columns), np.array(values), choices


def selections(
    choices: list[Choice], n: int, n_c: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the columns of every regulator of degree n, and of the remaining observer."""
    tables = {0: (np.zeros((1, 0), np.intp), np.zeros((1, 0), np.intp))}
    for choice in choices:
        grown: dict[int, list[tuple[Any, Any]]] = {}
        for degree, (inner, outer) in tables.items():
            for chosen, left in choice:
                if degree + len(chosen) <= n:
                    rows = len(inner)
                    grown.setdefault(degree + len(chosen), []).append(
                        (
                            np.hstack([inner, np.tile(np.array(chosen, np.intp), (rows, 1))]),
                            np.hstack([outer, np.tile(np.array(left, np.intp), (rows, 1))]),
                        )
                    )
        tables = {
            degree: (
                np.vstack([inner for inner, _ in parts]),
                np.vstack([outer for _, outer in parts]),
            )
            for degree, parts in grown.items()
        }
    empty = np.zeros((0, n), np.intp), np.zeros((0, n_c), np.intp)
    return tables.get(n, empty)


def solved(matrices: Array, right: Array) -> Array:
    """Return the solutions of many systems of equations; NaN for a singular matrix."""
    try:
        return np.asarray(np.linalg.solve(matrices, right))
    except np.linalg.LinAlgError:
        solution = np.full(right.shape, np.nan)
        for i, (matrix, column) in enumerate(zip(matrices, right, strict=True)):
            try:
                solution[i] = np.linalg.solve(matrix, column)
            except np.linalg.LinAlgError:
                continue
        return solution


def least_sines(blocks: Array) -> Array:
    """Return the least singular value of each block of orthonormal columns."""
    if not len(blocks):
        return np.zeros(0)
    return np.asarray(np.linalg.svd(blocks, compute_uv=False)[:, -1])


def norms(matrices: Array) -> Array:
    """Return the Frobenius norm of each matrix."""
    return np.asarray(np.sqrt((matrices**2).sum(axis=(1, 2))))
