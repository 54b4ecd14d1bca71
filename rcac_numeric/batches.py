"""Many runs at once, over threads."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError, InputError
from rcac_numeric import _kernel
from rcac_numeric.controller_settings import ControllerSettings
from rcac_numeric.decentralized import Decentralized
from rcac_numeric.prepared_runs import AnyPlant, PreparedRun
from rcac_numeric.runs import Run
from rcac_numeric.validation import integer, items

# Rows of each run between two looks at the keyboard.
CHUNK = 1 << 16


@dataclass(frozen=True, eq=False)
class Case:
    """The arguments of one `simulate`.

    Attributes
    ----------
    plant, settings, w
        As for `simulate`.
    options : mapping
        The keyword arguments of `simulate`: x_0, stride, divergence_limit, saturation, start.
    """

    plant: AnyPlant
    settings: ControllerSettings | Decentralized
    w: ArrayLike
    options: Mapping[str, Any] = field(default_factory=dict)


def simulate_many(cases: Iterable[Case], *, threads: int | None = None) -> list[Run]:
    """Run many cases over threads; the results are those of `simulate`, in the same order.

    Parameters
    ----------
    cases : iterable of Case
        Seeds, settings and plants may differ from case to case.
    threads : int, optional
        As many as there are processors by default. Functions of Python plants and weights run one
        at a time.

    Raises
    ------
    InputError
        Where a case is not valid; its number is named, and nothing has run.
    FunctionFailedError
        Where a function of a case failed; the attribute `run` is what `simulate` would give.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(structure=iir(n_c=2), target=fir_target(plant), R_theta=1)
    >>> cases = [Case(plant, settings, exogenous([white_noise()], 100, seed)) for seed in range(8)]
    >>> [run.outcome for run in simulate_many(cases)] == ["completed"] * 8
    True
    """
    workers = integer(os.cpu_count() or 1 if threads is None else threads, "threads", at_least=1)
    prepared = []
    for number, case in enumerate(items(cases, "cases")):
        if not isinstance(case, Case):
            raise InputError(f"case {number} is {case!r}; Case(plant, settings, w) is needed.")
        try:
            prepared.append(PreparedRun(case.plant, case.settings, case.w, **case.options))
        except TypeError as error:
            raise InputError(f"the options of case {number}: {error}.") from None
        except InputError as error:
            raise InputError(f"case {number}: {error}") from None
    jobs = [one.job for one in prepared]
    while _kernel.run_jobs(jobs, workers, CHUNK):
        pass
    runs = []
    for number, one in enumerate(prepared):
        try:
            runs.append(one.result())
        except FunctionFailedError as error:
            raise FunctionFailedError(f"case {number}: {error}", error.run) from error
    return runs
