"""Limits of memory and operations of an experiment, checked before its simulation."""

from __future__ import annotations

from dataclasses import dataclass

from compensator_theory.errors import Advice, InputError
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule

# In ball arithmetic a multiplication takes about as long as this many of the compiled step.
REFERENCE = 5000
# A predicted step of PCAC, in Python, takes about as long as this many.
PREDICTED = 1e5
# Operations of a step in addition to its l_theta^2 multiplications.
OVERHEAD = 100


@dataclass(frozen=True, eq=False)
class ExperimentBudget(Value):
    """Limits of memory and operations for an experiment.

    Attributes
    ----------
    memory : float
        In bytes, for the weights and records of one run with all its repetitions.
    operations : float
        Multiplications of all runs together: steps times repetitions times about l_theta^2; 1e5
        for each predicted step of PCAC. The default takes some minutes.

    Examples
    --------
    >>> from rcac_experiments import ExperimentBudget, load_experiment
    >>> case = load_experiment(
    ...     "examples/boost_converter.toml", budget=ExperimentBudget(memory=1e9))
    """

    memory: float = 5e8
    operations: float = 1e12

    def require_memory(
        self,
        name: str,
        plant: Plant | PlantSchedule,
        sizes: list[int],
        *,
        steps: int,
        stride: int,
        repetitions: int,
        window: int = 0,
    ) -> None:
        """Refuse a run of controllers with so many coefficients that exceeds the memory limit.

        R_theta, P(0), P and its factor are l_theta x l_theta; of every repetition w, u, y and z
        are kept, and theta at every stride-th step.
        """
        squares = 4 * sum(size**2 for size in sizes) + window * sum(sizes) * plant.l_z
        stored = 2 * plant.l_w + 2 * plant.l_u + plant.l_y + plant.l_z + sum(sizes) / stride
        needed = 8.0 * (squares + repetitions * steps * stored)
        if needed > self.memory:
            raise InputError(
                f"the run {name!r} of {steps} steps with l_theta = {sum(sizes)} coefficients and "
                f"{repetitions} repetition{'s' * (repetitions > 1)} needs {needed:.3g} bytes; the "
                f"limit is {self.memory:.3g}. Use a smaller n_c, fewer steps, a larger stride "
                f"or fewer repetitions; or raise the limit with ",
                _more("memory", needed),
                ".",
            )

    def operations_of(
        self, sizes: list[int], *, steps: int, repetitions: int, reference: bool, horizon: int = 0
    ) -> float:
        """Return the approximate number of multiplications of a run."""
        squares = sum(float(size) ** 2 for size in sizes)
        factor = REFERENCE if reference else 1
        of_step = (squares + OVERHEAD) * factor + PREDICTED * horizon
        return float(steps) * repetitions * of_step

    def require_operations(self, needed: float) -> None:
        """Refuse an experiment that exceeds the limit of operations."""
        if needed > self.operations:
            raise InputError(
                f"the runs need about {needed:.3g} operations (sum of steps x repetitions x "
                f"l_theta^2); the limit is {self.operations:.3g}. Use fewer steps or "
                f"repetitions; or raise the limit with ",
                _more("operations", needed),
                ".",
            )


def _more(limit: str, value: float) -> Advice:
    """Return advice to set the limit 5 % above the value."""
    needed_limit = f"{1.05 * value:.1e}"
    return Advice(
        "ExperimentBudget", ((limit, needed_limit),), f"{{function}}({limit}={needed_limit})"
    )
