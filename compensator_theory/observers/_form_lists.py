"""All observer-based forms of a realisation together, and the choice of one of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import sympy
from sympy import Expr, Poly

from compensator_theory._latex import displayed, latex, lines, words
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.matrices._certificates import Certified, Residuals
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.observers._counting import count_observer_forms
from compensator_theory.observers._form import ObserverForm
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import is_rational, product, total
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import is_discrete
from compensator_theory.roots._certified import certified_roots
from compensator_theory.systems._realisations import Realisation


@dataclass(frozen=True)
class ObserverForms(Certified, ExactValue):
    r"""The observer-based forms of :func:`observer_forms`, and the reasons why no others exist.

    Attributes
    ----------
    plant, compensator : Realisation
        As given.
    characteristic_polynomial : sympy.Poly
        :math:`\tilde D = \det(sI - \tilde A)`.
    forms : tuple of ObserverForm
        One for each regulator polynomial that determines its subspace.
    families : tuple of ObserverForm
        With free parameters, where the closed loop has several Jordan blocks for one root: all
        forms of one component of the continuum but a thin set of them. One without parameters
        represents a continuum whose parametrised families give no form.
    rejections : tuple of (sympy.Poly, str)
        Regulator polynomials that give no form, each with the reason.
    undecided : tuple of sympy.Poly
        Regulator polynomials with a continuum of subspaces of which none that was tried gives a
        form.
    continua : tuple of (sympy.Poly, int, int)
        Regulator polynomials with a continuum of invariant subspaces, its dimension, and how many
        irreducible components of that dimension it has.

    Notes
    -----
    Source: (7.11)-(7.18); the subspaces are :math:`\ker p_R(\tilde A)`.
    """

    _REST: ClassVar[str] = ".forms, .families, .rejections and .undecided list them"
    identity = "the identities of every form, p_R p_O = D~, det(sI - A~) = D~"

    plant: Realisation
    compensator: Realisation
    characteristic_polynomial: Poly
    forms: tuple[ObserverForm, ...]
    families: tuple[ObserverForm, ...] = ()
    rejections: tuple[tuple[Poly, str], ...] = ()
    undecided: tuple[Poly, ...] = ()
    continua: tuple[tuple[Poly, int, int], ...] = ()

    def _residuals(self) -> Residuals:
        whole, s = closed_loop_matrix(self.plant, self.compensator), self.plant.variable
        minus = self.characteristic_polynomial * -1
        yield total(characteristic_polynomial(whole, s), minus)
        for form in (*self.forms, *self.families):
            yield from form._residuals()
            yield total(product(form.regulator, form.observer), minus)

    @property
    def has_continuum(self) -> bool:
        """Whether there are infinitely many forms."""
        return bool(self.families)

    @property
    def number_of_candidates(self) -> int | None:
        """Number of real monic regulator polynomials of degree n.

        None where the closed loop has symbols or irrational coefficients: they are not counted.
        """
        if not is_rational(self.characteristic_polynomial):
            return None
        return count_observer_forms(self.characteristic_polynomial, self.plant.n)

    @property
    def is_complete(self) -> bool | None:
        """Whether every real regulator polynomial is rational and so was tested.

        None where :attr:`number_of_candidates` is.

        The forms of irrational regulator polynomials are found in float64, by
        ``rcac_numeric.observer_forms``.
        """
        spectra = {form.regulator for form in (*self.forms, *self.families)}
        spectra |= {polynomial for polynomial, _ in self.rejections} | set(self.undecided)
        candidates = self.number_of_candidates
        return None if candidates is None else len(spectra) == candidates

    def continuum(self, regulator: Poly) -> str:
        """Return a phrase with the dimension of the subspaces of a regulator polynomial."""
        for polynomial, dimension, components in self.continua:
            if polynomial == regulator:
                parts = f" in {components} components" if components > 1 else ""
                return f"a continuum of subspaces of dimension {dimension}{parts}"
        return "a single subspace"

    def fastest_observer(self) -> ObserverForm:
        """Return the form whose slowest observer root is fastest.

        Slow is a large real part in the variable s (continuous time), and a large modulus in z and
        q (discrete time); another variable says neither and is refused.

        Raises
        ------
        NoSolutionError
            If there is no form.
        InputError
            If the variable is none of s, z and q.
        """
        discrete = is_discrete(self.plant.variable, "which observer is fastest")
        measure: Callable[[complex], float] = abs if discrete else lambda root: root.real

        def slowest(form: ObserverForm) -> float:
            return max((measure(root.value) for root in certified_roots(form.observer)), default=0)

        return self._least(slowest)

    def best_conditioned(self) -> ObserverForm:
        """Return the form with the least :attr:`ObserverForm.squared_condition` of T.

        Raises
        ------
        NoSolutionError
            If there is no form.
        """
        return self._least(lambda form: form.squared_condition)

    def closest_to(self, K: MatrixLike, F: MatrixLike) -> ObserverForm:
        r"""Return the form that minimises :math:`\|K - K_0\|_F^2 + \|F - F_0\|_F^2`.

        Parameters
        ----------
        K, F : matrix
            The gains :math:`K_0` and :math:`F_0`, for instance those of an LQG design; in the
            convention A + BK, A - FC.

        Raises
        ------
        InputError
            If the shapes do not fit or :math:`n_c \ne n`, so that there is no F.
        NoSolutionError
            If there is no form.
        """
        gains = exact_matrix(K, "K"), exact_matrix(F, "F")
        shapes = self.plant.B.T.shape, self.plant.C.T.shape
        if self.plant.n != self.compensator.n or (gains[0].shape, gains[1].shape) != shapes:
            raise InputError(
                f"K and F are {gains[0].shape} and {gains[1].shape}; full-order forms of this "
                f"plant have gains of shapes {shapes[0]} and {shapes[1]}"
            )

        def distance(form: ObserverForm) -> Expr:
            off = [*(form.K - gains[0]), *(form.F - gains[1])]
            return sympy.Add(*(entry**2 for entry in off))

        return self._least(distance)

    def _least(self, cost: Callable[[ObserverForm], Expr | float]) -> ObserverForm:
        if not self.forms:
            raise NoSolutionError(
                "there is no isolated form to choose from; "
                + (
                    "choose parameters of a family with families[0].at(...)"
                    if self.families
                    else "see rejections for the reasons"
                )
            )
        return min(self.forms, key=cost)

    def __str__(self) -> str:
        lines = [f"closed loop {format_polynomial(self.characteristic_polynomial)}"]
        lines += [f"{i}. {form}" for i, form in enumerate((*self.forms, *self.families), start=1)]
        lines += [
            f"   one of {self.continuum(form.regulator)}"
            for form in self.families
            if not form.parameters
        ]
        lines += [f"none for regulator {format_polynomial(p)}: {why}" for p, why in self.rejections]
        lines += [
            f"undecided for regulator {format_polynomial(p)}: {self.continuum(p)}, and no tested "
            "subspace gives a form"
            for p in self.undecided
        ]
        if self.is_complete is False:
            lines.append("more candidates have irrational coefficients and were not tested")
        return "\n".join(lines)

    def _repr_latex_(self) -> str:
        forms = [*self.forms, *self.families]
        return displayed(lines(map(latex, forms)) if forms else words("no form"))
