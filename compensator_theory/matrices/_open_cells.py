"""Grassmannians of invariant subspaces, by the open cell, and subspaces with a cyclic quotient."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

import sympy
from sympy import ImmutableMatrix, Matrix, Symbol

from compensator_theory.matrices._cyclic_families import krylov, subspace_family
from compensator_theory.matrices._invariant_subspaces import (
    PrimaryComponent,
    joined,
    kernel,
    primary_components,
)
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.polynomials._letters import names_in_all, numbered

Family = tuple[ImmutableMatrix, tuple[Symbol, ...]]
"""A basis with free parameters, and the parameters."""


def grassmannian_cell(
    matrix: Matrix, component: PrimaryComponent, exponent: int, names: Iterator[Symbol]
) -> Family:
    r"""Parametrise the subspaces between two kernels, where every subspace is invariant.

    .. math:: \ker f^j \subset V \subset \ker f^{j+1}, \qquad
              V = \ker f^j + \mathrm{span}\Big\{\tilde A^t\big(b_i + \sum_{l > w}
              \alpha_{il}(\tilde A)\,b_l\big)\Big\}_{i \le w}
    """
    d = component.degree
    j = max(k for k, below in enumerate(component.kernels) if below.cols <= exponent * d)
    below, above = component.kernels[j], component.kernels[j + 1]
    w = exponent - below.cols // d
    generators: list[Matrix] = []
    span = below
    for column in range(above.cols):
        longer = joined(matrix.rows, [span, krylov(matrix, above[:, column], d)])
        if rank(longer) == longer.cols:
            generators.append(above[:, column])
            span = longer
    blocks: list[Matrix] = [below]
    parameters: list[Symbol] = []
    for i in range(w):
        general = generators[i]
        for other in generators[w:]:
            row_parameters = tuple(islice(names, d))
            parameters += row_parameters
            powers = krylov(matrix, other, d)
            general = general + powers * Matrix(d, 1, list(row_parameters))
        blocks.append(krylov(matrix, general, d))
    return joined(matrix.rows, blocks), tuple(parameters)


def cocyclic_family(
    matrix: Matrix, component: PrimaryComponent, exponent: int, names: Iterator[Symbol]
) -> Family | None:
    """Parametrise the subspaces whose quotient in the component is cyclic, by duality.

    The annihilator of such a subspace is a cyclic one of the transpose.
    """
    whole = component.factor**component.multiplicity
    (dual,) = primary_components(matrix.T, whole)
    rest = component.multiplicity - exponent
    family = subspace_family(matrix.T, dual, rest, names) if dual.has_continuum(rest) else None
    if family is None:
        return None
    annihilator, parameters = family
    all_of_it = component.kernels[component.multiplicity]
    inside = kernel(ImmutableMatrix(annihilator.T * all_of_it))
    basis = (all_of_it * inside).applyfunc(sympy.cancel)
    return ImmutableMatrix(basis), parameters


def families(matrix: Matrix, chosen: Sequence[tuple[PrimaryComponent, int]]) -> tuple[Family, ...]:
    """Every parametrised family of invariant subspaces with one polynomial, largest first."""
    bases: list[Family] = [(joined(matrix.rows, []), ())]
    enough = len(chosen) * (matrix.rows**2 + 1)
    letters = numbered(names_in_all(matrix), "alpha", enough)
    for component, exponent in chosen:
        if not component.has_continuum(exponent):
            options: list[Family] = [(component.kernels[exponent], ())]
        else:
            count = max(len(parameters) for _, parameters in bases)
            start = letters[count : count + matrix.rows**2 + 1]
            candidates = (
                subspace_family(matrix, component, exponent, iter(start)),
                grassmannian_cell(matrix, component, exponent, iter(start)),
                cocyclic_family(matrix, component, exponent, iter(start)),
            )
            known = [family for family in candidates if family is not None]
            options = [family for family in known if family[1]] or known  # a point is no family
        bases = [
            (joined(matrix.rows, [basis, more]), (*parameters, *others))
            for basis, parameters in bases
            for more, others in options
        ]
    return tuple(sorted(bases, key=lambda family: -len(family[1])))
