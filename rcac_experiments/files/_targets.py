"""The target models of an experiment file."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._parts import Unresolved
from rcac_experiments.format._places import Place
from rcac_experiments.format._tables import Deferred, Kind, Kinds, Table, Variant
from rcac_experiments.format._values import (
    Choice,
    Exact,
    Integer,
    ListOf,
    Numbers,
    OneOrMore,
    Row,
)
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule, plant_at
from rcac_numeric.targets._data_driven import INPUTS, LITERAL, DataDriven
from rcac_numeric.targets._filters import target_model
from rcac_numeric.targets._high_authority import high_authority_target_model
from rcac_numeric.targets._markov import markov_target
from rcac_numeric.targets._model import TargetModel
from rcac_numeric.targets._modelling import ModellingInformation, modelling_information
from rcac_numeric.targets._output_subspaces import output_subspace_target
from rcac_numeric.targets._pole_placement import fir_target, pole_placement_target
from rcac_numeric.targets._zero_directions import (
    DirectionInformation,
    zero_direction_target,
)

# Filters whose poles must be found exactly, and plants whose zeros must be, in about a second.
LARGEST_ORDER, LARGEST_N_BAR, LARGEST_PLANT, LARGEST_DIRECTED, LARGEST_TAPS = 200, 600, 80, 20, 20


class TargetKind(Unresolved):
    """A target model, but for what it takes from the plant."""

    def of(self, plant: Plant | PlantSchedule) -> TargetModel:
        """The target model for this plant, for what it is at step 0."""
        return self.made(plant_at(plant, 0))

    @abstractmethod
    def made(self, plant: Plant) -> TargetModel:
        """The target model for a plant that does not change."""


RELATIVE_DEGREE = (
    "What RCAC assumes of the relative degree of G_zu; that of the plant where it is left out."
)
LEADING = (
    "Of its leading coefficient; likewise. For the servo problem G_zu = -G_u, so that it is minus"
    " the leading coefficient of G."
)
NMP_ZEROS = "Of its zeros on or outside the unit circle; likewise."


@attrs.frozen
class Fir(TargetKind):
    """The FIR target model (2.49), or (2.50) where there are NMP zeros."""

    d_zu: Annotated[int | None, RELATIVE_DEGREE] = None
    H: Annotated[Any, Exact(), LEADING] = None
    nmp_zeros: Annotated[list[Any] | None, ListOf(Exact()), NMP_ZEROS] = None

    def made(self, plant: Plant) -> TargetModel:
        """From what is said, and the plant for the rest."""
        return fir_target(self.information(plant))

    def information(self, plant: Plant) -> ModellingInformation:
        """What the file says of G_zu; the rest is taken from the plant."""
        zeros = None if self.nmp_zeros is None else tuple(self.nmp_zeros)
        if self.d_zu is not None and self.H is not None:
            return ModellingInformation(self.d_zu, self.H, zeros or ())
        return _information(plant).changed(d_zu=self.d_zu, H=self.H, nmp_zeros=zeros)


@attrs.frozen
class PolePlacement(Fir):
    """The pole-placement target model (4.38), or (4.39) where there are NMP zeros."""

    poles: Annotated[Any, Exact(), "The roots of D_p, or D_p itself."]
    d_zu: Annotated[int | None, RELATIVE_DEGREE] = None
    H: Annotated[Any, Exact(), LEADING] = None
    nmp_zeros: Annotated[list[Any] | None, ListOf(Exact()), NMP_ZEROS] = None

    def made(self, plant: Plant) -> TargetModel:
        """From what is said, and the plant for the rest."""
        return pole_placement_target(self.information(plant), self.poles)


@attrs.frozen
class MarkovOfPlant(TargetKind):
    """The Markov-parameter target model of section 2.4.5, a truncation of (2.51)."""

    n_bar: Annotated[
        int,
        Integer(at_most=LARGEST_N_BAR),
        "Index of the last Markov parameter that is kept.",
    ]

    def made(self, plant: Plant) -> TargetModel:
        """With the plant's Markov parameters."""
        return markov_target(plant, self.n_bar)


@attrs.frozen(eq=False)
class Markov(TargetKind):
    """The target model of section 2.4.5 with Markov parameters of your own."""

    markov_parameters: Annotated[
        Array,
        "H_0, H_1, ... in place of the plant's: numbers, or l_z x l_u matrices.",
    ]
    n_bar: Annotated[
        int | None,
        "Index of the last one that is kept; all of them where it is left out.",
    ] = None

    def made(self, plant: Plant) -> TargetModel:
        """With the plant's relative degree."""
        return _with_relative_degree_of(plant, markov_target(self.markov_parameters, self.n_bar))


@attrs.frozen
class Filter(TargetKind):
    """Any filter."""

    G_f: Annotated[
        Any,
        Exact(),
        "In q, with the relative degree of G_zu and no pole outside the unit circle.",
    ]

    def made(self, plant: Plant) -> TargetModel:
        """With the plant's relative degree."""
        return _with_relative_degree_of(plant, target_model(self.G_f))


@attrs.frozen(eq=False)
class Coefficients(TargetKind):
    """Any filter, by its coefficients."""

    numerator: Annotated[Array, "In place of G_f: a coefficient for each power of q^{-1}."]
    denominator: Annotated[
        Array | None,
        Numbers(LARGEST_ORDER + 1),
        "Likewise; the first one is the identity. 1 where it is left out.",
    ] = None

    def made(self, plant: Plant) -> TargetModel:
        """With the plant's relative degree."""
        return _with_relative_degree_of(plant, TargetModel(self.numerator, self.denominator))


@attrs.frozen
class HighAuthority(TargetKind):
    """The target model of high-authority LQG, (4.24) corrected; scalar u, w, y and z."""

    def made(self, plant: Plant) -> TargetModel:
        """From the plant."""
        return high_authority_target_model(plant)


@attrs.frozen
class OutputSubspace(TargetKind):
    """The FIR target model of section 3.3, for more performance variables than inputs."""

    def made(self, plant: Plant) -> TargetModel:
        """From the plant."""
        return output_subspace_target(plant)


NUMBER_OF_TAPS = (
    "Number of coefficients behind the leading one; the least that is enough where it is left out."
)


@attrs.frozen(eq=False)
class ZeroDirections(TargetKind):
    """The FIR target model with the plant's NMP zeros in their directions."""

    taps: Annotated[int | None, Integer(at_most=LARGEST_TAPS), NUMBER_OF_TAPS] = None
    squaring: Annotated[
        Array | None,
        "S with u = S v, for a plant with more control inputs than performance variables.",
    ] = None

    def made(self, plant: Plant) -> TargetModel:
        """From the plant."""
        if plant.n > LARGEST_DIRECTED:
            raise InputError(
                f"the plant has {plant.n} states; zero directions are found up to "
                f'{LARGEST_DIRECTED}. Use model = "markov".'
            )
        return zero_direction_target(plant, self.taps, self.squaring)


ZEROS = ListOf(Row((Exact(), ListOf(Exact(), 1)), "[z0, [eta_1, ...]]"))


@attrs.frozen(eq=False)
class GivenDirections(TargetKind):
    """The same with H, zeros and directions of your own."""

    H: Annotated[Array, "The first coefficient that is not zero of every row of G_zu."]
    zeros: Annotated[
        list[Any],
        ZEROS,
        "NMP zeros and their left directions, eta' G_zu(z0) = 0; of a complex pair one.",
    ]
    delays: Annotated[
        int | list[int],
        OneOrMore(Integer(at_most=10_000)),
        "Relative degree of G_zu, or of each of its rows.",
    ] = 1
    taps: Annotated[int | None, Integer(at_most=LARGEST_TAPS), NUMBER_OF_TAPS] = None

    def made(self, plant: Plant) -> TargetModel:
        """Whatever the plant is."""
        information = DirectionInformation(self.H, self.zeros, self.delays)
        return zero_direction_target(information, self.taps)


class _LearntFrom(Choice):
    """The inputs of `DataDriven`; the literal u~ is passed on to it, which says why it is none."""

    def read(self, value: object, place: Place) -> str:
        """As a str."""
        return str(value) if value in LITERAL else super().read(value, place)


TARGETS: Kinds[TargetKind | DataDriven] = Kinds(
    {
        "fir": Fir,
        "pole placement": PolePlacement,
        "markov": Kind(Variant(Markov, "markov_parameters"), Variant(MarkovOfPlant)),
        "high authority": HighAuthority,
        "output subspace": OutputSubspace,
        "data driven": Table(DataDriven, forms={"input": _LearntFrom(INPUTS)}),
        "zero directions": Kind(Variant(GivenDirections, "zeros"), Variant(ZeroDirections)),
        "filter": Kind(Variant(Coefficients, "numerator"), Variant(Filter)),
    }
)


@attrs.frozen(eq=False)
class Target(Unresolved):
    """The target model G_f."""

    model: Annotated[TargetKind | DataDriven, TARGETS, "Which target model."]

    def of(self, plant: Plant | PlantSchedule) -> TargetModel | DataDriven:
        """The target model for this plant, or how it is learnt."""
        return self.model if isinstance(self.model, DataDriven) else self.model.of(plant)


TARGET = Deferred(Table(Target), is_replaced=True)


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
