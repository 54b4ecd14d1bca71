"""Checks of exact examples: a statement, what it is about, and its verdict without a tolerance."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.exact import placements, sylvester
from rcac_numeric.experiments.exact.placements import Found
from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.format.places import did_you_mean

Statement = Callable[..., Found]
STATEMENTS: dict[str, Statement] = {
    function.__name__: function
    for function in (
        placements.regulator_gain,
        placements.observer_gain,
        placements.observer_based_compensator,
        placements.closed_loop,
        placements.placement,
        placements.no_unique_placement,
        placements.observer_based,
        placements.placed_pair_is_observer_based,
        sylvester.sylvester_matrix,
        sylvester.sylvester_rank,
        sylvester.sylvester_determinant,
        sylvester.common_roots,
    )
}


@dataclass(frozen=True, eq=False)
class ExactCheck(Value):
    """A statement that is so or is not, decided exactly.

    Attributes
    ----------
    statement : str
        A name of `STATEMENTS`.
    system : ExactSystem
        What it is about.
    arguments : mapping
        The keyword arguments of the statement.

    Examples
    --------
    >>> from rcac_numeric.experiments.exact.checks import ExactCheck
    >>> from rcac_numeric.experiments.exact.system import ExactSystem
    >>> pair = ExactSystem(a="s + 1", b="(s + 1)*(s + 2)")
    >>> result = ExactCheck("common_roots", pair, {"equals": 1}).evaluate()
    >>> result.holds, str(result)
    (True, '1 common roots')
    """

    statement: str
    system: ExactSystem
    arguments: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "arguments", dict(self.arguments))
        if self.statement not in STATEMENTS:
            raise InputError(
                f"there is no statement {self.statement!r}; known are {', '.join(STATEMENTS)}."
                f"{did_you_mean(self.statement, STATEMENTS)}"
            )
        try:
            inspect.signature(STATEMENTS[self.statement]).bind(self.system, **self.arguments)
        except TypeError as error:
            raise InputError(f"the statement {self.statement!r}: {error}.") from None

    @property
    def runs(self) -> tuple[str, ...]:
        """None: nothing runs."""
        return ()

    def moved(self, moves: Mapping[str, str]) -> ExactCheck:
        """Itself: it is of no run."""
        return self

    def evaluate(self, results: Mapping[str, object] | None = None) -> ExactResult:
        """Decide it; nothing that ran has a part in it."""
        try:
            found = STATEMENTS[self.statement](self.system, **self.arguments)
        except CompensatorError as error:
            raise type(error)(f"the statement {self.statement!r}: {error}") from None
        return ExactResult(self, found.holds, found.words)


@dataclass(frozen=True, eq=False)
class ExactResult(Value):
    """What was found exactly, and whether it is what is claimed.

    Attributes
    ----------
    check : ExactCheck
    holds : bool or None
        None where it is undecided.
    found : str
        In words.
    silence : str
        Empty: what is decided exactly has an answer.
    """

    check: ExactCheck
    holds: bool | None
    found: str
    silence: str = ""

    def __str__(self) -> str:
        return self.found
