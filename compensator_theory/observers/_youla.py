"""Compensators with more states than the plant: an observer with a Youla parameter."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from sympy import ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.loops._siso import agreed_sign
from compensator_theory.matrices._certificates import Certified
from compensator_theory.matrices._invariant_subspaces import (
    PrimaryComponent,
    divisors,
    joined,
    kernel,
    primary_components,
)
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank, solve
from compensator_theory.matrices._strata import continuum_size
from compensator_theory.polynomials._budget import quoted
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical, total
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._realisations import Realisation


@dataclass(frozen=True)
class YoulaForm(Certified, ExactValue):
    r"""An observer, state feedback, and a stable or unstable filter of the innovations.

    .. math::
        \dot{\hat x} &= A\hat x + Bu + F(y - C\hat x), \qquad
        \dot x_q = A_q x_q + B_q(y - C\hat x), \\
        u &= K\hat x + C_q x_q, \qquad x_c = T\begin{bmatrix} \hat x \\ x_q \end{bmatrix}

    Attributes
    ----------
    plant, compensator : Realisation
        As given, of orders n and :math:`n_c > n`.
    T : sympy.ImmutableMatrix
        :math:`n_c \times n_c`, invertible.
    regulator, observer, parameter : sympy.Poly
        Characteristic polynomials of A + BK, A - FC and :math:`A_q`.

    Notes
    -----
    Source: (7.11), (7.12) and the parametrisation of Youla; the text stops at :math:`n_c = n`.
    """

    identity = "T^-1 A_c T, T^-1 B_c, C_c T are an observer with a filter, with these spectra"

    plant: Realisation
    compensator: Realisation
    T: ImmutableMatrix
    regulator: Poly
    observer: Poly
    parameter: Poly

    @property
    def transformed(self) -> Realisation:
        r"""The compensator with the state :math:`(\hat x, x_q)`."""
        return self.compensator.in_basis(self.T)

    @property
    def K(self) -> ImmutableMatrix:
        """Regulator gain."""
        return self.transformed.C[:, : self.plant.n]

    @property
    def F(self) -> ImmutableMatrix:
        """Observer gain."""
        return self.transformed.B[: self.plant.n, :]

    @property
    def Q(self) -> Realisation:
        r"""The Youla parameter :math:`(A_q, B_q, C_q)`, from innovation to control."""
        n, inner = self.plant.n, self.transformed
        B_q, C_q = inner.B[n:, :], inner.C[:, n:]
        A_q = inner.A[n:, n:] + B_q * self.plant.D * C_q  # the observer subtracts D_0 u
        period = self.plant.sample_time
        return Realisation(A_q, B_q, C_q, None, self.plant.variable, sample_time=period)

    def _residuals(self) -> list[ImmutableMatrix | Poly]:
        plant, Q, K, F, s = self.plant, self.Q, self.K, self.F, self.plant.variable
        C_hat = plant.C + plant.D * K  # the estimate of y is C_hat x_hat + D_0 C_q x_q
        top = (plant.A + plant.B * K - F * C_hat).row_join((plant.B - F * plant.D) * Q.C)
        bottom = (-Q.B * C_hat).row_join(Q.A - Q.B * plant.D * Q.C)
        spectra = (
            (plant.A + plant.B * K, self.regulator),
            (plant.A - F * plant.C, self.observer),
            (Q.A, self.parameter),
        )
        return [
            top.col_join(bottom) - self.transformed.A,
            *(total(characteristic_polynomial(M, s), poly * -1) for M, poly in spectra),
        ]

    def __str__(self) -> str:
        parts = ("regulator", "observer", "parameter")
        spectra = [f"{part} {format_polynomial(getattr(self, part))}" for part in parts]
        return (
            "; ".join(spectra) + f"\n  K = {text(self.K.tolist())}, F = {text(self.F.tolist())}, "
            f"T = {text(self.T.tolist())}"
        )

    def _repr_latex_(self) -> str:
        return displayed(
            f"p_R = {latex(self.regulator)}",
            f"p_O = {latex(self.observer)}",
            f"p_Q = {latex(self.parameter)}",
            *(f"{name} = {latex(getattr(self, name))}" for name in ("K", "F", "T")),
        )


@refusing
def youla_forms(
    plant: RealisationLike,
    compensator: RealisationLike,
    *,
    feedback: int | None = None,
    variable: str | Symbol | None = None,
) -> tuple[YoulaForm, ...]:
    r"""Find every rational three-way form of a compensator with more states than the plant.

    .. math:: \tilde D = p_R\,p_Q\,p_O, \qquad
              \ker p_R(\tilde A) \subset \ker p_R(\tilde A)p_Q(\tilde A)

    Parameters
    ----------
    plant : realisation
        Of order n; anything :func:`realisation` reads.
    compensator : realisation
        Of order :math:`n_c > n`, strictly proper, :math:`u = C_c x_c`.
    feedback : {+1, -1}, optional
        The sign f in :math:`u = f C_c x_c`; default +1. With -1 the compensator of the result has
        the sign in its output matrix. A compensator of :func:`place_poles` knows its sign, and
        another one is refused.
    variable : str or Symbol, optional
        Of both; default: evident, bare matrices need it.

    Returns
    -------
    tuple of YoulaForm
        Every chain of subspaces with rational polynomials that gives a form.

    Raises
    ------
    InputError
        If :math:`n_c \le n`, signals do not fit, or the closed loop is derogatory, so that the
        subspaces form continua.

    Notes
    -----
    For a minimal SISO plant and a minimal compensator every chain works: the quotient of the closed
    loop by the larger subspace is an n-dimensional invariant subspace of the transposed loop, to
    which the lemma for regulators applies. Over the reals there may be a regulator and yet no
    three-way form: n = 1 and :math:`n_c = 2` with a single real root.

    Examples
    --------
    >>> from compensator_theory import realisation
    >>> from compensator_theory.observers import youla_forms
    >>> forms = youla_forms("1/(s - 1)", realisation("-24/(s**2 + 7*s + 18)"))
    >>> len(forms), all(form.is_verified for form in forms)
    (6, True)
    """
    system, controller_realisation = (
        realisation(plant, variable),
        realisation(compensator, variable),
    )
    controller = controller_realisation.with_sign(agreed_sign(controller_realisation, feedback))
    n, n_c = system.n, controller.n
    if n_c <= n:
        raise InputError(f"the compensator has n_c = {n_c} <= n = {n} states; use observer_forms")
    loop = closed_loop_matrix(system, controller)
    whole = characteristic_polynomial(loop, system.variable)
    components = primary_components(loop, whole)
    for component in components:
        if component.is_derogatory:
            raise InputError(
                f"the closed loop has several Jordan blocks for {quoted(component.factor)}, of "
                f"lengths {', '.join(map(str, component.block_lengths))}: its Youla forms "
                f"make up a continuum of dimension {_sizes(component)}, as its invariant subspaces "
                "do. Remove the hidden mode of the compensator"
            )
    forms = []
    for (inner, p_R), (outer, both) in itertools.product(
        divisors(components, n), list(divisors(components, n_c))
    ):
        if all(i <= o for i, o in zip(inner, outer, strict=True)):
            T = _basis(_stacked(components, inner), _stacked(components, outer), n)
            if T is not None:
                p_Q, p_O = canonical(both.exquo(p_R)), canonical(whole.exquo(both))
                forms.append(YoulaForm(system, controller, T, p_R, p_O, p_Q))
    return tuple(forms)


def _sizes(component: PrimaryComponent) -> str:
    """Name the dimension for every power of the factor that has a continuum."""
    powers = [e for e in range(component.multiplicity) if component.has_continuum(e)]
    return ", ".join(f"{continuum_size([(component, e)])[0]} for its power {e}" for e in powers)


def _stacked(
    components: tuple[PrimaryComponent, ...], exponents: tuple[int, ...]
) -> ImmutableMatrix:
    chosen = zip(components, exponents, strict=True)
    return joined(components[0].kernels[0].rows, [c.kernels[e] for c, e in chosen])


def _basis(inner: ImmutableMatrix, outer: ImmutableMatrix, n: int) -> ImmutableMatrix | None:
    """Return [T_1, S] with im [I; T_1] = inner and im [0; S] inside outer, if it is invertible."""
    if rank(inner[:n, :]) < n:
        return None
    estimate = solve(inner[:n, :].T, inner[n:, :].T).T
    rest = outer[n:, :] * kernel(outer[:n, :])
    basis = joined(outer.rows - n, [estimate, rest])
    return basis if basis.cols == basis.rows == rank(basis) else None
