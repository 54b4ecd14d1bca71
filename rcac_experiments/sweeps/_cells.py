"""From coordinates to cases: each cell is computed once, and its plant once for many cells."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.experiments._experiment import RunSpecification
from rcac_experiments.files._runs import RunTables, read_again, read_run, require_sense
from rcac_experiments.sweeps._canonical import canonical_json
from rcac_experiments.sweeps._study import Coordinates, Study
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import replaced
from rcac_numeric.controllers._settings import ControllerSettings, settings_with_numbers
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.engine._batches import SimulationCase
from rcac_numeric.signals._signal import Signal
from rcac_numeric.targets._model import TargetModel

T = TypeVar("T")
# Cells, and plants, that a worker remembers.
REMEMBERED = 64


@dataclass
class Cell:
    """One combination of the axes' values.

    Attributes
    ----------
    specification : RunSpecification or None
        None for a study of a function, whose cases are made one by one.
    remembered : dict
        What measures have found that is the same for all runs of the cell.
    """

    study: Study
    coordinates: Coordinates
    specification: RunSpecification | None
    remembered: dict[Any, Any]

    @property
    def target(self) -> TargetModel | None:
        """The reference of a controller without a target model."""
        return None if self.specification is None else self.specification.target

    @property
    def is_reference(self) -> bool:
        """Whether it is run in ball arithmetic."""
        return self.specification is not None and self.specification.reference

    @property
    def is_stepwise(self) -> bool:
        """Whether its steps are Python, so that no batch runs it."""
        specification = self.specification
        return specification is not None and isinstance(specification.settings, StepwiseController)

    @cached_property
    def words(self) -> tuple[int, ...]:
        """The key of the cell's noise, beside the seed."""
        if self.study.common_noise:
            return ()
        return words_of({axis.sets: self.coordinates[axis.name] for axis in self.study.axes})

    def w(self, repetition: int) -> Array:
        """The exogenous input of one run."""
        specification = self.specification
        assert specification is not None
        return exogenous_input(
            specification.signals,
            specification.steps,
            self.study.seed,
            self.words,
            repetition,
            specification.perturbation,
        )

    def case(self, repetition: int) -> SimulationCase:
        """The specification of the run."""
        specification = self.specification
        if specification is not None:
            options: dict[str, Any] = {"stride": self._stride(specification)}
            if specification.saturation is not None:
                options["saturation"] = specification.saturation
            return SimulationCase(
                specification.plant, specification.settings, self.w(repetition), options
            )
        assert callable(self.study.base)
        rng = generator(self.study.seed, self.words, repetition, WHOLE_RUN)
        case = self.study.base(rng, **self.coordinates)
        if not isinstance(case, SimulationCase):
            raise InputError(f"the function of the study returned {case!r}, no SimulationCase.")
        return case

    def _stride(self, specification: RunSpecification) -> int:
        """The interval of stored theta, most of the memory: only metrics of theta need it."""
        study = self.study
        looks = "theta" in study.keep_signals or any(metric.needs_theta for metric in study.keep)
        return specification.stride if looks else max(specification.steps, 1)


# Entries of [controller] that are numbers of a controller, whatever else stands there.
OF_UPDATE = {"controller.R_theta": "R_theta", "controller.lambda": "lambda_"}
OF_SETTINGS = {f"controller.{name}": name for name in ("R_z", "R_u", "theta_0")}
OF_START = {f"controller.{name}": name for name in ("k_w", "k_update")}


class Cells:
    """Makes the cells of a study, with a cache of the last ones and their parts.

    Of a document only the tables that are others are read again. Where an axis sets a number of the
    controller, the settings of a cell that differs in such numbers alone are taken with its own.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self._cells: OrderedDict[str, Cell] = OrderedDict()
        self._plants: OrderedDict[str, Any] = OrderedDict()
        self._targets: OrderedDict[str, Any] = OrderedDict()
        self._read: tuple[dict[str, Any], RunTables] | None = None
        self._built: tuple[Any, Any, Any] | None = None
        self._plant: tuple[Any, str] | None = None
        self._alike: OrderedDict[str, RunSpecification] = OrderedDict()
        numbers = {**OF_UPDATE, **OF_SETTINGS, **OF_START}
        self._numbers = [axis for axis in study.axes if axis.sets in numbers]
        self._others = [axis for axis in study.axes if axis.sets not in numbers]

    def cell(self, coordinates: Coordinates) -> Cell:
        """One cell."""
        return _remembered(
            self._cells, canonical_json(coordinates), lambda: self._new_cell(coordinates)
        )

    def _new_cell(self, coordinates: Coordinates) -> Cell:
        study = self.study
        if callable(study.base):
            return Cell(study, coordinates, None, {})
        key = canonical_json({axis.name: coordinates[axis.name] for axis in self._others})
        if (alike := self._alike.get(key)) is not None and self._numbers:
            specification = self._with_numbers(alike, coordinates)
            if specification is not None:
                return Cell(study, coordinates, specification, {})
        specification = self._specification(study.document(coordinates))
        _remembered(self._alike, key, lambda: specification)
        return Cell(study, coordinates, specification, {})

    def _specification(self, document: dict[str, Any]) -> RunSpecification:
        """A document with a cache of the objects built from it."""
        file = self.study.file
        if self._read is None:
            tables = read_run(document, {"name": "main"}, file)
            assert tables is not None
        else:
            before, of_before = self._read
            tables = read_again(of_before, before, document, file)
        self._read = document, tables
        if self._plant is None or self._plant[0] is not document["plant"]:
            self._plant = document["plant"], canonical_json(document["plant"])
        of_plant = self._plant[1]
        plant = _remembered(self._plants, of_plant, tables.plant.build)
        built = self._built
        if built is None or built[0] is not tables.controller or built[1] is not plant:
            target = tables.controller.target
            known = None
            if target is not None:
                of_target = f"{of_plant} {canonical_json(document['target'])}"
                known = _remembered(self._targets, of_target, lambda: target.of(plant))
            built = tables.controller, plant, tables.controller.build(plant, known)
            self._built = built
        return tables.build(plant, built[2])

    def _with_numbers(
        self, alike: RunSpecification, coordinates: Coordinates
    ) -> RunSpecification | None:
        """A specification with other numbers in its controller; None where the tables are asked."""
        settings = alike.settings
        if type(settings) is not ControllerSettings:
            return None
        of_update: dict[str, Any] = {}
        of_settings: dict[str, Any] = {}
        start: dict[str, Any] = {}
        for axis in self._numbers:
            value = coordinates[axis.name]
            if axis.sets in OF_UPDATE:
                of_update[OF_UPDATE[axis.sets]] = value
            elif axis.sets in OF_SETTINGS:
                of_settings[OF_SETTINGS[axis.sets]] = value
            else:
                start[OF_START[axis.sets]] = value
        if start:
            table = self.study.base["controller"]  # type: ignore[index]
            of_settings |= {name: start.get(name, table.get(name)) for name in OF_START.values()}
        try:
            changed = settings_with_numbers(settings, of_update, of_settings)
            specification = None if changed is None else replaced(alike, settings=changed)
            if start and specification is not None:
                require_sense(specification)
        except CompensatorError:
            return None  # the tables say what is wrong, and where it stands
        return specification


def _remembered(store: OrderedDict[str, T], key: str, make: Callable[[], T]) -> T:
    if key not in store:
        if len(store) >= REMEMBERED:
            store.popitem(last=False)
        store[key] = make()
    store.move_to_end(key)
    return store[key]


# Random numbers of a run, from the seed of the study and the run's own coordinates alone.

# A channel of w has its number; what is drawn beside the channels has these.
PERTURBATION, WHOLE_RUN = 2**32 - 1, 2**32 - 2
WORD = 2**32  # integers below are one word of a seed sequence


def words_of(by_path: dict[str, Any]) -> tuple[int, ...]:
    """Coordinates as four integers below 2^32: the same however many other values there are."""
    key = hashlib.blake2b(canonical_json(by_path).encode(), digest_size=16).digest()
    return tuple(int(word) for word in np.frombuffer(key, "<u4"))


def generator(
    seed: int, words: tuple[int, ...], repetition: int, channel: int
) -> np.random.Generator:
    """Return the independent generator of one channel of one run."""
    key = (*words, repetition, channel)
    if seed < WORD**2 and repetition < WORD:
        # What SeedSequence makes of the seed and the key, four times as fast as from integers.
        pool = np.array([seed % WORD, seed // WORD, 0, 0, *key], dtype=np.uint32)
        sequence = np.random.SeedSequence(pool)
    else:
        sequence = np.random.SeedSequence(seed, spawn_key=key)
    return np.random.Generator(np.random.PCG64(sequence))


def exogenous_input(
    signals: tuple[Signal, ...],
    steps: int,
    seed: int,
    words: tuple[int, ...],
    repetition: int,
    perturbation: float = 0.0,
) -> Array:
    """The exogenous input w of one run, shape (steps, number of signals).

    With a perturbation, all repetitions but the first are multiplied by
    1 + perturbation * (standard normal).
    """
    w = np.empty((steps, len(signals)))
    for channel, signal in enumerate(signals):
        w[:, channel] = signal.samples(steps, generator(seed, words, repetition, channel))
    if perturbation and repetition:
        rng = generator(seed, words, repetition, PERTURBATION)
        w *= 1 + perturbation * rng.standard_normal(w.shape)
    return w
