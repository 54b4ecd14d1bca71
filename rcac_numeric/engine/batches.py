"""Many runs at once, over threads."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import attrs
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer, items
from rcac_numeric.arrays.values import Value
from rcac_numeric.engine.compatibility import AnyController
from rcac_numeric.engine.interruption import run_to_end
from rcac_numeric.engine.jobs import PreparedRun
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.any_plant import AnyPlant
from rcac_numeric.plants.foreign import as_plant


@attrs.frozen(eq=False, slots=False)
class SimulationCase(Value):
    """The arguments of one `simulate`.

    Parameters
    ----------
    plant, settings, w
        As for `simulate`; a system of python-control, SciPy or SymPy is read by `plant_of`, and
        the plant is what is kept.
    options : mapping
        The keyword arguments of `simulate`: x_0, stride, divergence_limit, saturation, start.

    Examples
    --------
    >>> import control
    >>> from rcac_numeric import Compensator, FixedController, SimulationCase
    >>> law = FixedController(Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[-0.1]]]))
    >>> case = SimulationCase(control.tf([1], [1, -0.5], 0.01), law, [[1.0]] * 20)
    >>> case.plant.sample_time
    0.01
    """

    plant: AnyPlant = attrs.field(converter=as_plant)
    settings: AnyController
    w: ArrayLike
    options: Mapping[str, Any] = attrs.field(factory=dict)

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "options", self.options or {})


def simulate_many(
    cases: Iterable[SimulationCase], *, threads: int | None = None, lanes: bool = False
) -> list[Run]:
    """Run many cases over threads; the results come in the same order.

    Without lanes they are those of `simulate`, bit for bit. A case's result never depends on
    which other cases are there, nor on the number of threads.

    Parameters
    ----------
    cases : iterable of SimulationCase
        Seeds, settings and plants may differ from case to case.
    threads : int, optional
        As many as there are processors by default. Functions of Python plants and weights run one
        at a time.
    lanes : bool
        Let eligible cases with equal structures and sizes go in lock step, eight at a time, one to
        a lane of the processor's vectors: per case about 5 times faster than one after another
        for l_theta = 8, 3.5 times for 20 and 1.8 times for 40 (benchmarks/closed_loop.py). Fewer
        than eight cost what eight do, so lanes pay from 2, 3 and 5 cases on. Plants, signals,
        settings and lengths may differ within the eight.

        Sums are then taken in another order than in `simulate`, and neither order is the more
        accurate. Two runs differ by what the loop makes of relative changes of its data at every
        step by 4 (l_theta + n + l_w + 8) * 2.2e-16 or less. Where that is much, as in a loop that
        grows without bound or with data that leave theta open (`Run.guard_count`), the digits of
        `simulate` are as uncertain.

        Eligible is: one controller with ``update = UD(R_theta, lambda_)``, a number each, in the
        predictor form, without process_noise, reset, stop_where_unsupported, freeze,
        target_changes, reflect_poles, R_u_unfiltered, z_normalization, bounds and fixed,
        k_filter = 0, no derived signals (PID, integrators), l_z <= 3; R_z and R_u constant or, for
        l_z = 1, a `SignalWeight` without nu, their sum for l_z = 1 between 1e-100 and 1e100; a
        plant of constant matrices without delay; no saturation. All other cases give what
        `simulate` gives, bit for bit.

    Raises
    ------
    InputError
        Where a case is not valid; its number is named, and nothing has run.
    RunInterrupted
        On Ctrl-C, within about 0.1 s; its attribute `runs` holds all runs so far.

    A case whose function failed ends with the outcome "plant failed" or "weight failed" and says
    why in `Run.failure`; the other cases are not touched.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, SimulationCase, WhiteNoise, exogenous, fir_target, iir,
    ...     simulate_many, standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1))
    >>> noise = [exogenous([WhiteNoise()], 100, seed) for seed in range(8)]
    >>> cases = [SimulationCase(plant, settings, w) for w in noise]
    >>> runs, in_lanes = simulate_many(cases), simulate_many(cases, lanes=True)
    >>> [run.outcome for run in runs] == ["completed"] * 8
    True
    >>> all(abs(a.u - b.u).max() < 1e-12 for a, b in zip(runs, in_lanes))
    True
    """
    workers = integer(os.cpu_count() or 1 if threads is None else threads, "threads", at_least=1)
    instance_of(lanes, "lanes", bool)
    prepared = []
    for number, case in enumerate(items(cases, "cases")):
        if not isinstance(case, SimulationCase):
            raise InputError(
                f"case {number} is {case!r}; SimulationCase(plant, settings, w) is needed."
            )
        try:
            prepared.append(PreparedRun(case.plant, case.settings, case.w, **case.options))
        except TypeError as error:
            raise InputError(f"the options of case {number}: {error}.") from None
        except InputError as error:
            raise InputError(f"case {number}: {error}") from None
    run_to_end(prepared, workers, lanes)
    return [one.result() for one in prepared]
