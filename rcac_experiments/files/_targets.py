"""The target models of an experiment file: the functions of `rcac_numeric.targets`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any

from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_experiments.format._places import Location
from rcac_experiments.format._signatures import Composed
from rcac_experiments.format._tables import Kind, Kinds, PartialTable, Table, Variant
from rcac_experiments.format._values import (
    Choice,
    Exact,
    Integer,
    ListOf,
    Numbers,
    OneOrMore,
    Row,
)
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule, plant_at
from rcac_numeric.targets._data_driven import INPUTS, LITERAL, DataDriven
from rcac_numeric.targets._filters import target_model
from rcac_numeric.targets._high_authority import high_authority_target
from rcac_numeric.targets._markov import markov_target
from rcac_numeric.targets._model import TargetModel
from rcac_numeric.targets._modelling import ModellingInformation, modelling_information
from rcac_numeric.targets._output_subspaces import output_subspace_target
from rcac_numeric.targets._pole_placement import fir_target, pole_placement_target
from rcac_numeric.targets._zero_directions import (
    DirectionInformation,
    zero_direction_target,
)

# Limits for exact poles of filters and exact zeros of plants, in about a second.
LARGEST_ORDER, LARGEST_N_BAR, LARGEST_PLANT, LARGEST_DIRECTED, LARGEST_TAPS = 200, 600, 80, 20, 20
# The keys of a file for parameters with another name in the library.
NAMES = {"source": "markov_parameters", "filter": "G_f"}
FORMS = {
    "poles": Exact(),
    "source": Numbers(),
    "zeros": ListOf(Row((Exact(), ListOf(Exact(), 1)), "[z0, [eta_1, ...]]")),
    "delays": OneOrMore(Integer(at_most=10_000)),
    "taps": Integer(at_most=LARGEST_TAPS),
    "denominator": Numbers(LARGEST_ORDER + 1),
    "filter": Exact(),
}
DOCS = {
    "poles": "The roots of D_p, or D_p itself.",
    "source": "H_0, H_1, ... in place of the plant's: numbers, or l_z x l_u matrices.",
    "n_bar": "Index of the last one that is kept; all of them where it is left out.",
    "zeros": "NMP zeros and their left directions, eta' G_zu(z0) = 0; of a complex pair one.",
    "delays": "Relative degree of G_zu, or of each of its rows.",
    "taps": "Number of coefficients behind the leading one; the least that is enough where it is "
    "left out.",
    "squaring": "S with u = S v, for a plant with more control inputs than performance variables.",
    "numerator": "In place of G_f: a coefficient for each power of q^{-1}.",
    "denominator": "Likewise; the first one is the identity. 1 where it is left out.",
    "filter": "In q, with the relative degree of G_zu and no pole outside the unit circle.",
}


def _model(
    make: Callable[..., TargetModel],
    words: str = "",
    *,
    computed: Sequence[str] = (),
    needs: Sequence[str] = (),
    **makers: Callable[..., Any],
) -> Table[TargetModel]:
    """Return the table of a function that makes a target model, for the plant at step 0."""
    whole = Composed(make, words, plant=_at_first, **makers)
    return Table(
        whole, supplied=("plant", *computed), needs=needs, forms=FORMS, names=NAMES, docs=DOCS
    )


def _at_first(plant: Plant | PlantSchedule) -> Plant:
    return plant_at(plant, 0)


def known_of(
    plant: Plant,
    d_zu: Annotated[
        int | None,
        "The relative degree of G_zu that RCAC assumes; by default that of the plant.",
    ] = None,
    H: Annotated[
        Any,
        Exact(),
        "Of its leading coefficient; likewise. For the servo problem G_zu = -G_u, so that it is "
        "minus the leading coefficient of G.",
    ] = None,
    nmp_zeros: Annotated[
        list[Any] | None,
        ListOf(Exact()),
        "Of its zeros on or outside the unit circle; likewise.",
    ] = None,
) -> ModellingInformation:
    """Facts about G_zu of the file; the others come from the plant."""
    zeros = None if nmp_zeros is None else tuple(nmp_zeros)
    if d_zu is not None and H is not None:
        return ModellingInformation(d_zu, H, zeros or ())
    return _information(plant).changed(d_zu=d_zu, H=H, nmp_zeros=zeros)


def fitting(plant: Plant, target: TargetModel) -> TargetModel:
    """Return the target model if its relative degree is that of a scalar G_zu."""
    if (plant.l_z, plant.l_u) != (1, 1):
        return target
    if target.relative_degree != (d_zu := _information(plant).d_zu):
        raise InputError(
            f"the target model G_f has relative degree {target.relative_degree}, the plant's "
            f"G_zu has {d_zu}; the intercalated transfer function always has that of G_zu "
            "(4.18). Multiply G_f by a power of q."
        )
    return target


def markov_of_plant(
    plant: Plant, n_bar: Annotated[int, Integer(at_most=LARGEST_N_BAR)]
) -> TargetModel:
    """The Markov-parameter target model of section 2.4.5, a truncation of (2.51)."""
    return markov_target(plant, n_bar)


def of_directions(known: DirectionInformation, taps: int | None = None) -> TargetModel:
    """The target model of zeros and directions that a file says."""
    return zero_direction_target(known, taps=taps)


def of_plant_directions(
    plant: Plant, taps: int | None = None, squaring: ArrayLike | None = None
) -> TargetModel:
    """The target model of a plant whose zeros and their directions can be found."""
    if plant.n > LARGEST_DIRECTED:
        raise InputError(
            f"the plant has {plant.n} states; zero directions need at most "
            f'{LARGEST_DIRECTED}. Use model = "markov".'
        )
    return zero_direction_target(plant, taps=taps, squaring=squaring)


class _LearntFrom(Choice):
    """The inputs of `DataDriven`; the literal u~ is passed on to it, which says why it is none."""

    def read(self, value: object, place: Location) -> str:
        """Read the value as a str."""
        return str(value) if value in LITERAL else super().read(value, place)


TARGETS: Kinds[Any] = Kinds(
    {
        "fir": _model(fir_target, information=known_of),
        "pole placement": _model(pole_placement_target, information=known_of),
        "markov": Kind(
            Variant(
                _model(
                    fitting,
                    "The target model of section 2.4.5 with Markov parameters of your own.",
                    target=markov_target,
                ),
                "markov_parameters",
            ),
            Variant(_model(markov_of_plant)),
        ),
        "high authority": _model(
            high_authority_target,
            "The target model of high-authority LQG, (4.24) corrected; scalar u, w, y and z.",
        ),
        "output subspace": _model(
            output_subspace_target,
            "The FIR target model of section 3.3, for more performance variables than inputs.",
        ),
        "data driven": Table(DataDriven, forms={"input": _LearntFrom(INPUTS)}),
        "zero directions": Kind(
            Variant(
                _model(
                    of_directions,
                    "The same with H, zeros and directions of your own.",
                    needs=["zeros"],
                    known=DirectionInformation,
                ),
                "zeros",
            ),
            Variant(
                _model(
                    of_plant_directions,
                    "The FIR target model with the plant's NMP zeros in their directions.",
                )
            ),
        ),
        "filter": Kind(
            Variant(
                _model(
                    fitting,
                    "Any filter, by its coefficients.",
                    computed=["exact"],
                    target=TargetModel,
                ),
                "numerator",
            ),
            Variant(_model(fitting, "Any filter.", target=target_model)),
        ),
    }
)


def _target(model: Annotated[Any, TARGETS, "Which target model."]) -> Any:
    """The target model G_f."""
    return model


TARGET = PartialTable(Table(_target, is_later=True), is_replaced=True)


def _information(plant: Plant) -> ModellingInformation:
    if plant.n > LARGEST_PLANT:
        raise InputError(
            f"the plant has {plant.n} states; exact relative degree and zeros need at most "
            f"{LARGEST_PLANT}. Give d_zu, H and nmp_zeros in [target]."
        )
    return modelling_information(plant)
