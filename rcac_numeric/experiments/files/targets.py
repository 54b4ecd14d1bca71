"""The target models of an experiment file."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.experiments.format.deferred import Deferred
from rcac_numeric.experiments.format.lists import ListOf, OneOrMore, Row
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Kind, Kinds, Table, Variant
from rcac_numeric.experiments.format.values import Choice, Exact, Integer, Numbers
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.data_driven import INPUTS, LITERAL, DataDriven
from rcac_numeric.targets.directions.zero_directions import (
    DirectionInformation,
    zero_direction_target,
)
from rcac_numeric.targets.filters import target_model
from rcac_numeric.targets.high_authority import high_authority_target_model
from rcac_numeric.targets.markov import markov_target
from rcac_numeric.targets.model import TargetModel
from rcac_numeric.targets.modelling import ModellingInformation, modelling_information
from rcac_numeric.targets.output_subspaces import output_subspace_target
from rcac_numeric.targets.pole_placement import fir_target, pole_placement_target


def _fir(
    plant: Plant, d_zu: int | None = None, H: Any = None, nmp_zeros: list[Any] | None = None
) -> TargetModel:
    """The FIR target model (2.49), or (2.50) where there are NMP zeros.

    Parameters
    ----------
    d_zu : int
        What RCAC is told of the relative degree of G_zu; that of the plant where it is left out.
    H : number
        Of its leading coefficient; likewise. For the servo problem G_zu = -G_u, so that it is
        minus the leading coefficient of G.
    nmp_zeros : list of numbers
        Of its zeros on or outside the unit circle; likewise.
    """
    return fir_target(_told(plant, d_zu, H, nmp_zeros))


def _pole_placement(
    plant: Plant,
    poles: Any,
    d_zu: int | None = None,
    H: Any = None,
    nmp_zeros: list[Any] | None = None,
) -> TargetModel:
    """The pole-placement target model (4.38), or (4.39) where there are NMP zeros.

    Parameters
    ----------
    poles : list of roots, or str
        The roots of D_p, or D_p itself.
    """
    return pole_placement_target(_told(plant, d_zu, H, nmp_zeros), poles)


def _markov_of_plant(plant: Plant, n_bar: int) -> TargetModel:
    """The Markov-parameter target model of section 2.4.5, a truncation of (2.51).

    Parameters
    ----------
    n_bar : int
        Index of the last Markov parameter that is kept.
    """
    return markov_target(plant, n_bar)


def _markov(plant: Plant, markov_parameters: Any, n_bar: int | None = None) -> TargetModel:
    """The target model of section 2.4.5 with Markov parameters of your own.

    Parameters
    ----------
    markov_parameters : array
        H_0, H_1, ... in place of the plant's: numbers, or l_z x l_u matrices.
    n_bar : int
        Index of the last one that is kept; all of them where it is left out.
    """
    return _with_relative_degree_of(plant, markov_target(markov_parameters, n_bar))


def _filter(plant: Plant, G_f: Any) -> TargetModel:
    """Any filter.

    Parameters
    ----------
    G_f : transfer function
        In q, with the relative degree of G_zu and no pole outside the unit circle.
    """
    return _with_relative_degree_of(plant, target_model(G_f))


def _coefficients(plant: Plant, numerator: Any, denominator: Any = None) -> TargetModel:
    """Any filter, by its coefficients.

    Parameters
    ----------
    numerator : list of numbers or of l_z x l_u matrices
        In place of G_f: a coefficient for each power of q^{-1}.
    denominator : list of numbers or of l_z x l_z matrices
        Likewise; the first one is the identity. 1 where it is left out.
    """
    return _with_relative_degree_of(plant, TargetModel(numerator, denominator))


def _high_authority(plant: Plant) -> TargetModel:
    """The target model of high-authority LQG, (4.24) corrected; scalar u, w, y and z."""
    return high_authority_target_model(plant)


def _output_subspace(plant: Plant) -> TargetModel:
    """The FIR target model of section 3.3, for more performance variables than inputs."""
    return output_subspace_target(plant)


def _zero_directions(plant: Plant, taps: int | None = None, squaring: Any = None) -> TargetModel:
    """The FIR target model with the plant's NMP zeros in their directions.

    Parameters
    ----------
    taps : int
        Number of coefficients behind the leading one; the least that is enough where it is left
        out.
    squaring : array
        S with u = S v, for a plant with more control inputs than performance variables.
    """
    if plant.n > LARGEST_DIRECTED:
        raise InputError(
            f"the plant has {plant.n} states; zero directions are found up to {LARGEST_DIRECTED}. "
            'Use model = "markov".'
        )
    return zero_direction_target(plant, taps, squaring)


def _said_zero_directions(
    plant: Plant, H: Any, zeros: Any, delays: Any = 1, taps: int | None = None
) -> TargetModel:
    """The same with H, zeros and directions of your own.

    Parameters
    ----------
    H : array
        The first coefficient that is not zero of every row of G_zu.
    zeros : list of [z0, [eta_1, eta_2, ...]]
        NMP zeros and their left directions, eta' G_zu(z0) = 0; of a complex pair one.
    delays : int, or list of int
        Relative degree of G_zu, or of each of its rows.
    """
    return zero_direction_target(DirectionInformation(H, zeros, delays), taps)


class _LearntFrom(Choice):
    """The inputs of `DataDriven`; the literal u~ is passed on to it, which says why it is none."""

    def read(self, value: object, place: Place) -> str:
        """As a str."""
        return str(value) if value in LITERAL else super().read(value, place)


# Filters whose poles must be found exactly, and plants whose zeros must be, in about a second.
LARGEST_ORDER, LARGEST_N_BAR, LARGEST_PLANT, LARGEST_DIRECTED, LARGEST_TAPS = 200, 600, 80, 20, 20
TOLD = {"H": Exact(), "nmp_zeros": ListOf(Exact())}
GIVEN = ("plant",)

TARGETS: Kinds[TargetModel | DataDriven] = Kinds(
    {
        "fir": Table(_fir, given=GIVEN, forms=TOLD),
        "pole placement": Table(_pole_placement, given=GIVEN, forms={**TOLD, "poles": Exact()}),
        "markov": Kind(
            Variant(
                Table(_markov, given=GIVEN, forms={"markov_parameters": Numbers()}),
                "markov_parameters",
            ),
            Variant(
                Table(
                    _markov_of_plant,
                    given=GIVEN,
                    forms={"n_bar": Integer(at_most=LARGEST_N_BAR)},
                )
            ),
        ),
        "high authority": _high_authority,
        "output subspace": _output_subspace,
        "data driven": Table(DataDriven, forms={"input": _LearntFrom(INPUTS)}),
        "zero directions": Kind(
            Variant(
                Table(
                    _said_zero_directions,
                    given=GIVEN,
                    forms={
                        "H": Numbers(),
                        "zeros": ListOf(Row((Exact(), ListOf(Exact(), 1)), "[z0, [eta_1, ...]]")),
                        "delays": OneOrMore(Integer(at_most=10_000)),
                        "taps": Integer(at_most=LARGEST_TAPS),
                    },
                ),
                "zeros",
            ),
            Variant(
                Table(
                    _zero_directions,
                    given=GIVEN,
                    forms={"taps": Integer(at_most=LARGEST_TAPS), "squaring": Numbers()},
                )
            ),
        ),
        "filter": Kind(
            Variant(
                Table(
                    _coefficients,
                    given=GIVEN,
                    forms={"numerator": Numbers(), "denominator": Numbers(LARGEST_ORDER + 1)},
                ),
                "numerator",
            ),
            Variant(Table(_filter, given=GIVEN, forms={"G_f": Exact()})),
        ),
    },
    given=GIVEN,
)


def _target(model: TargetModel | DataDriven) -> TargetModel | DataDriven:
    """The target model G_f.

    Parameters
    ----------
    model : str
        Which target model.
    """
    return model


TARGET = Deferred(Table(_target, forms={"model": TARGETS}), is_replaced=True)


def _told(
    plant: Plant, d_zu: int | None, H: Any, nmp_zeros: list[Any] | None
) -> ModellingInformation:
    """What the file says of G_zu; the rest is taken from the plant."""
    zeros = None if nmp_zeros is None else tuple(nmp_zeros)
    if d_zu is not None and H is not None:
        return ModellingInformation(d_zu, H, zeros or ())
    known = _information(plant)
    return ModellingInformation(
        known.d_zu if d_zu is None else d_zu,
        known.H if H is None else H,
        known.nmp_zeros if zeros is None else zeros,
    )


def _information(plant: Plant) -> ModellingInformation:
    if plant.n > LARGEST_PLANT:
        raise InputError(
            f"the plant has {plant.n} states; its relative degree and zeros are found exactly up "
            f"to {LARGEST_PLANT}. Say d_zu, H and nmp_zeros in [target]."
        )
    return modelling_information(plant)


def _with_relative_degree_of(plant: Plant, target: TargetModel) -> TargetModel:
    """The target itself, if its relative degree is that of a scalar G_zu."""
    if (plant.l_z, plant.l_u) != (1, 1):
        return target
    if target.relative_degree != (wanted := _information(plant).d_zu):
        raise InputError(
            f"the target model G_f has relative degree {target.relative_degree}, the plant's "
            f"G_zu has {wanted}; the intercalated transfer function always has that of G_zu "
            "(4.18). Multiply G_f by a power of q."
        )
    return target
