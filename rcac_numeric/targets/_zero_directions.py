"""Target models for several inputs and outputs that keep NMP zeros and directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from sympy import Matrix, Poly, Symbol

import compensator_theory as exact
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.loops._directions import rational_matrix
from compensator_theory.matrices._linear_algebra import determinant, rank
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import complex_number, integer, real_array
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._transmission_zeros import rosenbrock_matrix
from rcac_numeric.targets._filters import target_model
from rcac_numeric.targets._markov import markov_parameters
from rcac_numeric.targets._model import TargetModel
from rcac_numeric.targets._modelling import zeros_not_inside
from rcac_numeric.targets._pole_placement import fir_target

DirectedZero: TypeAlias = tuple[complex, tuple[complex, ...]]
# Singular values of Rosenbrock's matrix below this share of the largest count as zero.
NULL = 1e-9


@dataclass(frozen=True, eq=False, init=False)
class DirectionInformation(Value):
    """Modelling information of RCAC about G_zu with several inputs and outputs.

    Parameters
    ----------
    H : array, shape (l_z, l_u)
        Row i is the first Markov parameter of row i of G_zu that is not zero; of full rank.
    zeros : sequence of pairs (z0, eta)
        The NMP transmission zeros with their left directions, eta' G_zu(z0) = 0 without
        conjugation; of a complex pair one. Where l_z > l_u they are those of H' G_zu.
    delays : int or sequence of int
        Relative degree of G_zu, or of each of its rows, in steps.

    Raises
    ------
    InputError
        If sizes do not fit or an entry is not a finite number.

    Examples
    --------
    >>> from rcac_numeric.targets import DirectionInformation
    >>> DirectionInformation(H=[[1, 0], [0, 2]], zeros=[(1.5, [1, -1])]).delays
    (1, 1)
    """

    H: Array
    zeros: tuple[DirectedZero, ...]
    delays: tuple[int, ...]

    def __init__(
        self,
        H: ArrayLike,
        zeros: Sequence[tuple[complex, Sequence[complex]]] = (),
        delays: int | Sequence[int] = 1,
    ) -> None:
        set_ = partial(object.__setattr__, self)
        set_("H", real_array(H, "H"))
        if self.H.ndim != 2 or not self.H.size:
            raise InputError(f"H has shape {self.H.shape}; an l_z x l_u matrix is needed.")
        try:
            pairs = [(z0, tuple(eta)) for z0, eta in zeros]
        except (TypeError, ValueError):
            raise InputError(f"zeros = {zeros!r} must be pairs (z0, eta).") from None
        read = [
            (complex_number(z0, "z0"), tuple(complex_number(entry, "eta") for entry in eta))
            for z0, eta in pairs
        ]
        set_("zeros", tuple(read))
        rows = len(self.H)
        listed = tuple(delays) if isinstance(delays, Sequence) else (delays,) * rows
        set_("delays", tuple(integer(d, "delays", at_most=10_000) for d in listed))
        if len(self.delays) != rows:
            raise InputError(f"delays has {len(self.delays)} entries; H has {rows} rows.")


def zero_direction_target(
    H: ArrayLike | DirectionInformation | Plant,
    zeros: Sequence[tuple[complex, Sequence[complex]]] = (),
    *,
    delays: int | Sequence[int] = 1,
    taps: int | None = None,
    squaring: ArrayLike | None = None,
) -> TargetModel:
    """The FIR target model that has the NMP zeros of G_zu in the directions in which G_zu blocks.

    G_f(q) = diag(q^-d_i) (I + L_1 q^-1 + ... + L_m q^-m) H,  eta_i' G_f(z_i) = 0

    Parameters
    ----------
    H : array of shape (l_z, l_u), DirectionInformation or Plant
        Row i is the first Markov parameter of row i of G_zu that is not zero; of full rank. Or all
        that is known of G_zu, without zeros and delays; of a plant, `direction_information` finds
        it.
    zeros, delays : optional
        Beside an array: as in `DirectionInformation`.
    taps : int, optional
        m; the least that is enough by default, 1 where the directions are independent.
    squaring : array, shape (l_u, l_z), optional
        S with u = S v, for a plant with l_u > l_z.

    Raises
    ------
    InputError, NoSolutionError
        As `compensator_theory.zero_direction_target` and `direction_information`.

    Notes
    -----
    `compensator_theory.zero_direction_target` answers the same exactly.

    With one real zero this is q^-d (I - z0 q^-1 eta eta'/eta'eta) H. H q^-d alone invites the
    controller to cancel the zero, the zero in every channel asks for one too many, and a zero in
    another direction is none of the plant's: `check_directions` says so by name. More taps have
    less energy; but where the zeros of a plant almost cancel poles the least number follows the
    plant's own coefficients best, and others diverged.

    Examples
    --------
    >>> from rcac_numeric.targets import DirectionInformation, zero_direction_target
    >>> zero_direction_target([[1, 0], [0, 2]], [(1.5, [1, -1])]).numerator[2]
    array([[-0.75,  1.5 ],
           [ 0.75, -1.5 ]])
    >>> known = DirectionInformation(H=[[1, 0], [0, 2]], zeros=[(1.5, [1, -1])])
    >>> zero_direction_target(known) == zero_direction_target(known.H, known.zeros)
    True
    """
    source = _source(H, zeros, delays)
    plant = source if isinstance(source, Plant) else None
    if isinstance(source, Plant):
        source = direction_information(source, squaring)
    elif squaring is not None:
        raise InputError("squaring belongs to a plant; H already says which inputs are used.")
    built = exact.zero_direction_target(
        source.H.tolist(),
        [(_plain(z0), [_plain(e) for e in eta]) for z0, eta in source.zeros],
        delays=source.delays,
        taps=taps,
    )
    target = target_model(built.transfer_matrix)
    if plant is None:
        return target
    if plant.l_z == plant.l_u == 1 and taps is None:
        return fir_target(plant)  # the exact zeros and directions
    # The zeros and directions of the plant are float64, so the target is not exact.
    return TargetModel(target.numerator, target.denominator)


def _source(
    H: Any, zeros: Sequence[tuple[complex, Sequence[complex]]], delays: int | Sequence[int]
) -> DirectionInformation | Plant:
    """Return the DirectionInformation of a plant, or of H with zeros and delays."""
    if not isinstance(H, DirectionInformation) and _is_matrix_of_numbers(H):
        return DirectionInformation(H, zeros, delays)
    if len(zeros) or delays != 1:
        raise InputError(
            f"a {type(H).__name__} has its own zeros and delays; leave them out, or give H, the "
            "array of the first Markov parameters."
        )
    return H if isinstance(H, DirectionInformation) else linear_plant(H, "H")


def _is_matrix_of_numbers(H: Any) -> bool:
    if isinstance(H, np.ndarray):
        return True
    rows = H if isinstance(H, list | tuple) else ()
    return bool(rows) and all(
        isinstance(row, list | tuple) and all(isinstance(x, Real) for x in row) for row in rows
    )


def direction_information(plant: Plant, squaring: ArrayLike | None = None) -> DirectionInformation:
    """Relative degrees, leading coefficients, NMP zeros and their directions of a plant's G_zu.

    Parameters
    ----------
    plant : Plant
        A tall G_zu (l_z > l_u) is squared by H', through which the controller sees z.
    squaring : array, shape (l_u, l_z), optional
        S with u = S v, needed for a wide G_zu (l_u > l_z), and only there. The zeros are those of
        G_zu S; H is H S S^+.

    Raises
    ------
    InputError
        If G_zu is wide and there is no `squaring`: H q^-d, the only choice without it, keeps the
        zeros of G_zu H' but not those of G_zu, and hides an instability where those are NMP. If H
        does not have full rank, a zero has fewer directions than its multiplicity, or an NMP zero
        is a pole of the plant too.

    Notes
    -----
    How many zeros are outside the unit circle is decided exactly, from the determinant of
    Rosenbrock's matrix; the directions are its left null vectors, by singular values.

    Examples
    --------
    >>> from rcac_numeric import Plant
    >>> from rcac_numeric.targets import direction_information
    >>> plant = Plant(A=[[0.5, 0.0], [0.0, 0.0]], B=[[1.0, 1.0], [0.5, 2.0]],
    ...               D_1=[[1.0], [0.0]], C=[[1.0, 0.0], [0.0, 1.0]], E_1=[[1.0, 0.0], [1.0, -1.0]])
    >>> direction_information(plant).zeros
    ()
    """
    plant = linear_plant(plant)
    H, delays, right = _leading(plant, squaring)
    if plant.l_z > plant.l_u:
        square = (H.T, Matrix.eye(plant.l_u))
    else:
        square = (Matrix.eye(plant.l_z), right)
    zeros = directed_zeros(plant, *square)
    if plant.l_u > plant.l_z:
        H = H * (right.T * right).inv() * right.T
    return DirectionInformation(np.array(H.tolist(), dtype=float), zeros, delays)


def directed_zeros(plant: Plant, left: Matrix, right: Matrix) -> tuple[DirectedZero, ...]:
    """Return the NMP zeros of the square map left G_zu right with their left directions."""
    n, pencil = plant.n, rosenbrock_matrix(plant, left)
    pencil = pencil[:, :n].row_join(pencil[:, n:] * right)
    q = Symbol("q")
    polynomial = Poly(determinant(pencil), q, domain="QQ")
    if polynomial.is_zero:
        raise NoSolutionError("G_zu is singular for every q; choose other variables.")
    poles = Poly(determinant(pencil[:n, :n]), q, domain="QQ")
    for factor, _ in polynomial.gcd(poles).factor_list()[1]:
        if shared := zeros_not_inside(factor):
            raise InputError(
                f"the NMP zero {shared[0]} is a pole of the plant too: a hidden mode, which no "
                "controller moves, or one in another direction. Give zeros and directions."
            )
    zeros: list[DirectedZero] = []
    values = [complex(z) for z in zeros_not_inside(polynomial)]
    constant = np.array(pencil.subs(q, 0).tolist(), dtype=complex)
    slope = np.diag([1.0] * n + [0.0] * (len(constant) - n))
    for z0 in dict.fromkeys(z for z in values if z.imag >= 0):
        U, singular, _ = np.linalg.svd(constant + z0 * slope)
        count = int((singular <= NULL * singular[0]).sum())
        if count != values.count(z0):
            raise NoSolutionError(
                f"the zero {z0:.6g} has multiplicity {values.count(z0)} and {count} directions; "
                "use markov_target, or move the zeros a little apart."
            )
        zeros += [(z0, _normalised(U[n:, -1 - k].conj())) for k in range(count)]
    return tuple(zeros)


def _leading(plant: Plant, squaring: ArrayLike | None) -> tuple[Matrix, tuple[int, ...], Matrix]:
    """Return H, delays and S; H belongs to G_zu S for a wide plant."""
    right = Matrix.eye(plant.l_u)
    if squaring is not None:
        if plant.l_u <= plant.l_z:
            raise InputError("squaring is for plants with more control inputs than l_z.")
        right = rational_matrix(real_array(squaring, "squaring").tolist(), "squaring")
        if right.shape != (plant.l_u, plant.l_z) or rank(right) < plant.l_z:
            raise InputError(
                f"squaring = {right.tolist()} must be {plant.l_u} x {plant.l_z}, of full rank."
            )
    parameters = markov_parameters(plant, plant.n + 1)
    if plant.l_u > plant.l_z and squaring is None:
        raise InputError(
            f"G_zu is {plant.l_z} x {plant.l_u}, wider than tall, and H q^-d would hide the NMP "
            "zeros of G_zu H'. Give squaring = S with u = S v, one input alone for instance, so "
            "that G_zu S has no NMP zero, or few; or use markov_target."
        )
    rows = [
        [[exact.exact_number(float(e)) for e in step] for step in parameters[:, i, :]]
        for i in range(plant.l_z)
    ]
    products = [[Matrix([step]) * right for step in row] for row in rows]
    if not all(any(any(step) for step in row) for row in products):
        raise InputError("a row of G_zu is zero: the control does not act on that entry of z.")
    delays = [next(k for k, step in enumerate(row) if any(step)) for row in products]
    if plant.l_z > plant.l_u:
        delays = [min(delays)] * plant.l_z
    H = Matrix.vstack(*(row[d] for row, d in zip(products, delays, strict=True)))
    if rank(H) < min(H.shape):
        raise InputError(
            f"the first Markov parameters of the rows, {H.tolist()}, do not have full rank: the "
            "zeros at infinity have directions too, which this target ignores. Use "
            "markov_target."
        )
    return H, tuple(delays), right


def _normalised(eta: ComplexArray) -> tuple[complex, ...]:
    """Return the vector with a real positive largest entry, so that real directions are real."""
    turned = eta * (abs(pivot := eta[np.argmax(np.abs(eta))]) / pivot)
    turned = turned / np.linalg.norm(turned)
    return tuple(complex(e) if abs(e.imag) > NULL else complex(e.real) for e in turned)


def _plain(value: complex) -> complex | float:
    return value.real if value.imag == 0 else value
