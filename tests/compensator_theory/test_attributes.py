"""What a name is, attribute or verb, does not depend on the result that one happens to hold."""

import inspect
from dataclasses import fields, is_dataclass

import compensator_theory
from compensator_theory import results
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._sample_times import System


def public_results():
    for module in (compensator_theory, results):
        for name in dir(module):
            kind = getattr(module, name)
            if inspect.isclass(kind) and issubclass(kind, ExactValue):
                yield kind


def verbs_without_arguments(kind):
    for name, value in inspect.getmembers_static(kind, inspect.isfunction):
        if not name.startswith("_") and len(inspect.signature(value).parameters) == 1:
            yield name


def test_a_result_holds_what_a_system_computes():
    """A system is asked, `G.poles()`; a result has it, `form.poles`, or takes an argument."""
    kinds = set(public_results())
    attributes = set()
    for kind in kinds:
        attributes |= {name for name, value in vars(kind).items() if isinstance(value, property)}
        attributes |= {field.name for field in fields(kind)} if is_dataclass(kind) else set()
    wrong = {
        f"{kind.__name__}.{name}()"
        for kind in kinds
        if not issubclass(kind, System)
        for name in verbs_without_arguments(kind)
        if name in attributes
    }
    assert len(kinds) > 80 and wrong == set()
