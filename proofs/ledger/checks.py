"""Running one piece of evidence: an identity, a property, a counterexample."""

import importlib
import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from compensator_theory.errors import InputError

from .entries import Counterexample, Property, Symbolic
from .outcomes import Fact, Outcome, Status


@dataclass(frozen=True)
class ForAll:
    """A predicate and the strategies that its arguments are drawn from.

    Examples
    --------
    >>> from hypothesis import strategies as st
    >>> from proofs.ledger.checks import for_all
    >>> @for_all(x=st.integers())
    ... def square(x):
    ...     '''A square is not negative.'''
    ...     return x * x >= 0
    >>> square.run(examples=20).status
    'holds'
    """

    name: str
    statement: str
    strategies: dict[str, Any]
    predicate: Callable[..., bool]

    @property
    def drawn(self) -> str:
        """The strategies in words."""
        return ", ".join(f"{key} of {strategy!r}" for key, strategy in self.strategies.items())

    def run(self, examples: int, kept: float = 0.5, *, shrinks: bool = True) -> Outcome:
        """Draw examples, the same ones in every run, until the predicate fails or is believed.

        It is not believed where fewer than half of the examples asked for, or a smaller share than
        `kept` of those drawn, came to an answer: the others were assumed away or filtered out.
        """
        from hypothesis import HealthCheck, Phase, given, settings
        from hypothesis import strategies as st
        from hypothesis.errors import Unsatisfiable

        answered, begun, false = 0, 0, ""

        def begin() -> None:
            nonlocal begun
            begun += 1

        @settings(
            max_examples=examples,
            database=None,
            derandomize=True,
            deadline=None,
            report_multiple_bugs=False,
            phases=(Phase.generate, Phase.shrink) if shrinks else (Phase.generate,),
            suppress_health_check=list(HealthCheck),
        )
        @given(_begun=st.builds(begin), **self.strategies)
        def search(_begun: None, **drawn: Any) -> None:
            nonlocal answered, false
            if not _is_true(self.predicate(**drawn)):
                false = "false for " + ", ".join(f"{k} = {v}" for k, v in drawn.items())
                raise AssertionError
            answered += 1

        try:
            search()
        except AssertionError:
            # the last one that failed is the smallest
            return Outcome("property", self.name, self.statement, "fails", detail=false)
        except Unsatisfiable:
            pass  # counted below
        if (
            answered < max(1, kept * begun)
            or answered < min(examples, 10) / 2
            or 2 * answered < examples
        ):
            few = f"only {answered} of {begun} draws came to an answer, for {examples} asked for"
            return Outcome("property", self.name, self.statement, "fails", detail=few)
        scope = f"{answered} examples of {self.drawn}"
        return Outcome("property", self.name, self.statement, "holds", scope)


def for_all(**strategies: Any) -> Callable[[Callable[..., bool]], ForAll]:
    """Turn a predicate into a property; its docstring is the statement.

    Examples
    --------
    >>> from hypothesis import strategies as st
    >>> from proofs.ledger.checks import for_all
    >>> @for_all(x=st.integers(0, 9))
    ... def small(x):
    ...     '''Every digit is below 5.'''
    ...     return x < 5
    >>> small.run(examples=100).detail
    'false for x = 5'
    """

    def decorate(predicate: Callable[..., bool]) -> ForAll:
        module = predicate.__module__.rsplit(".", maxsplit=1)[-1]
        name = f"{module}.{predicate.__name__}"
        if any(repr(value) == "data()" for value in strategies.values()):
            raise InputError(f"{name} draws within itself, so that a failure would not show what")
        return ForAll(name, statement_of(predicate), strategies, predicate)

    return decorate


def resolve(package: str, check: str) -> Any:
    """Return the check with the name ``module.name`` in ``proofs.package``.

    Raises
    ------
    InputError
        If there is none.

    Examples
    --------
    >>> from proofs.ledger.checks import resolve
    >>> resolve("symbolic", "separation.similarity")()
    True
    """
    module, _, name = check.partition(".")
    try:
        return getattr(importlib.import_module(f"proofs.{package}.{module}"), name)
    except (ModuleNotFoundError, AttributeError) as error:
        if isinstance(error, ModuleNotFoundError) and error.name == "hypothesis":
            raise InputError(
                "property tests need hypothesis: pip install 'compensator-theory[test]'"
            ) from error
        raise InputError(
            f"proofs/{package} has no check {check}; correct the entry in proofs/statements"
        ) from error


def statement_of(check: Callable[..., Any]) -> str:
    """Return the first paragraph of a docstring as one line.

    Examples
    --------
    >>> from proofs.ledger.checks import resolve, statement_of
    >>> statement_of(resolve("symbolic", "separation.similarity"))
    "(7.18): S A~ = A~' S."
    """
    return " ".join((inspect.getdoc(check) or "").split("\n\n")[0].split())


def run_symbolic(evidence: Symbolic, *, quick: bool = False) -> Outcome:
    """Check an identity, for all sizes but the largest if quick.

    Examples
    --------
    >>> from proofs.ledger.checks import run_symbolic
    >>> from proofs.ledger.entries import Symbolic
    >>> run_symbolic(Symbolic("separation.similarity")).status
    'holds'
    """
    check = resolve("symbolic", evidence.check)
    sizes = evidence.sizes[:-1] if quick and len(evidence.sizes) > 1 else evidence.sizes
    evidence = replace(evidence, sizes=sizes)
    try:
        false = [n for n in sizes if not _is_true(check(n))] if sizes else not _is_true(check())
    except Exception as error:  # a check that cannot be computed confirms nothing
        return _raised("symbolic", evidence.check, check, error)
    detail = "" if not false else f"false for sizes {false}" if sizes else "the sides differ"
    status: Status = "fails" if false else "holds"
    words = statement_of(check)
    return Outcome("symbolic", evidence.check, words, status, evidence.scope, detail)


def run_property(evidence: Property, *, quick: bool = False) -> Outcome:
    """Search for a counterexample, among a tenth of the examples if quick.

    Examples
    --------
    >>> from proofs.ledger.checks import run_property
    >>> from proofs.ledger.entries import Property
    >>> run_property(Property("polynomials.lemma_1", 10)).status
    'holds'
    """
    check = resolve("properties", evidence.check)
    try:
        few = max(3, evidence.examples // 10)
        outcome: Outcome = check.run(few if quick else evidence.examples, evidence.kept)
    except Exception as error:
        return _raised("property", evidence.check, check.predicate, error)
    return outcome


def run_counterexample(evidence: Counterexample) -> Outcome:
    """Compute a counterexample; it holds if all of its facts do.

    Examples
    --------
    >>> from proofs.ledger.checks import run_counterexample
    >>> from proofs.ledger.entries import Counterexample
    >>> outcome = run_counterexample(Counterexample("...", "resultants.both_leading_zeros"))
    >>> outcome.status, len(outcome.facts)
    ('holds', 2)
    """
    check: Callable[[], Iterator[tuple[str, bool]]] = resolve("counterexamples", evidence.check)
    try:
        facts = tuple(Fact(statement, _is_true(holds)) for statement, holds in check())
    except Exception as error:
        return _raised("counterexample", evidence.check, check, error)
    false = [fact.statement for fact in facts if not fact.holds]
    status: Status = "holds" if facts and not false else "fails"
    words = statement_of(check)
    detail = "; ".join(f"not so: {statement}" for statement in false)
    name, wording = evidence.check, evidence.refutes
    return Outcome("counterexample", name, wording, status, words, detail, facts)


def _is_true(answer: object) -> bool:
    """Take True only for true: a generator, an expression or a text is no answer."""
    if answer is None or isinstance(answer, bool):
        return answer is True
    raise TypeError(f"the check gave {answer!r}, neither True nor False")


def _raised(kind: Any, name: str, check: Callable[..., Any], error: Exception) -> Outcome:
    detail = f"{type(error).__name__}: {error}"
    return Outcome(kind, name, statement_of(check), "fails", detail=detail)
