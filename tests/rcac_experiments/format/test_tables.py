"""What is new is one function and one line: its keys, errors, schema and words follow."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import attrs
import pytest

from compensator_theory import InputError
from rcac_experiments.files._reference import kind_keys_table, kinds_table
from rcac_experiments.files._schema import strict_schema
from rcac_experiments.files._structures import STRUCTURES
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.format._places import Location
from rcac_experiments.format._signatures import Composed, parameters_of
from rcac_experiments.format._tables import Kinds, Table, form_of
from rcac_experiments.format._values import Integer, Numbers
from rcac_numeric import Structure, Tap
from rcac_numeric.arrays._array_types import Array

PLACE = Location("case.toml", "controller")


def spread(
    n_c: int,
    spacing: Annotated[int, Integer(1), "Steps from one lag to the next."] = 2,
    memory: Annotated[Literal["long", "short"], "How much of it."] = "long",
    plant: Any = None,
) -> Structure:
    """Every second lag of y, or as you like."""
    taps = [Tap("y", 0, k) for k in range(1, n_c + 1, spacing)]
    return Structure(taps, 1, 1, n_c)


ALL = Kinds({**STRUCTURES.kinds, "spread": Table(spread, supplied=["plant"])}, default="iir")


@attrs.frozen
class Controller:
    """A controller."""

    structure: Annotated[Any, ALL]


TABLE = Table(Controller)


def read(**table):
    return TABLE.read(table, PLACE).structure


def test_it_is_read():
    assert read(structure="spread", n_c=5) == PartialCall(spread, {"n_c": 5}), (
        "as Python would say it"
    )
    taps = read(structure="spread", n_c=5).of(None).taps
    assert [tap.delay for tap in taps] == [1, 3, 5]
    taps = read(structure="spread", n_c=5, spacing=4).of(None).taps
    assert [tap.delay for tap in taps] == [1, 5]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"structure": "spraed", "n_c": 2}, "Did you mean 'spread'"),
        ({"structure": "spread"}, r"\[controller\] needs the key 'n_c'"),
        ({"structure": "spread", "n_c": 2, "spcing": 2}, "Did you mean 'spacing'"),
        ({"structure": "spread", "n_c": 2, "terms": "P"}, 'which structure = "spread" does not'),
        ({"structure": "fir", "n_c": 2, "spacing": 3}, 'which structure = "fir" does not read'),
        ({"structure": "spread", "n_c": 2, "spacing": "x"}, "spacing must be an integer"),
        ({"structure": "spread", "n_c": 2, "memory": "lnog"}, "Did you mean 'long'"),
    ],
)
def test_what_is_wrong_with_it_is_said(table, message):
    with pytest.raises(InputError, match=message):
        read(**table)


def test_all_that_is_wrong_is_said_at_once():
    with pytest.raises(InputError) as error:
        read(structure="spread", n_c=0.5, spacing=0, memory="lnog", terms="P")
    text = str(error.value)
    for part in ("n_c must be an integer", "spacing = 0", "memory = 'lnog'", "sets 'terms'"):
        assert part in text


def test_editors_know_it():
    schema = strict_schema(TABLE)
    assert "spread" in schema["properties"]["structure"]["enum"]
    assert schema["properties"]["memory"] == {"enum": ["long", "short"], "description": "How much of it."}  # fmt: skip  # noqa: E501
    conditions = {c["if"]["properties"]["structure"]["const"]: c["then"] for c in schema["allOf"]}
    assert conditions["fir"]["properties"]["spacing"] is False
    assert conditions["spread"]["anyOf"][0]["required"] == ["n_c"]


def test_it_is_documented():
    row = '| `"spread"` | Every second lag of y, or as you like. | `n_c`, [`spacing`], [`memory`] |'
    assert row in kinds_table("structure", ALL)
    assert "| `spacing` | Steps from one lag to the next. | 2 |" in kind_keys_table(ALL)


def test_a_field_that_cannot_be_read_is_noticed_where_it_is_declared():
    @attrs.frozen
    class Odd:
        """Odd."""

        matrix: set[int]

    with pytest.raises(TypeError, match=r"no form for the type .* for matrix"):
        Table(Odd).keys  # noqa: B018


def test_an_array_is_numbers_whatever_numpy_makes_of_its_types():
    assert isinstance(form_of(Array), Numbers)
    assert isinstance(form_of(Array | None), Numbers)


@dataclass
class Spring:
    """A spring.

    Parameters
    ----------
    stiffness : float
        In N/m.
    """

    stiffness: float = 1.0


def force(extension: float, spring: Spring) -> float:
    """The force of a spring.

    Parameters
    ----------
    extension : float
        In m.
    """
    return extension * spring.stiffness


def length(end: Annotated[float, "Where it ends, m."], spring: Spring) -> float:
    """How much longer than at rest it is."""
    return end - spring.stiffness / 10


OF_SPRING = Composed(force, "Of its end.", extension=length, spring=Spring)


def test_what_is_composed_asks_for_what_its_makers_ask_for():
    keys = [(key.name, key.doc, key.default) for key in Table(OF_SPRING).keys]
    assert keys == [("end", "Where it ends, m.", None), ("stiffness", "In N/m.", 1.0)]
    assert Table(OF_SPRING).summary == "Of its end."
    assert Table(OF_SPRING).read({"end": 3, "stiffness": 10}, PLACE) == (3 - 1) * 10
    assert OF_SPRING(end=3.0) == 3 - 0.1
    assert [one.name for one in parameters_of(Composed(force))] == ["extension", "spring"]
    for wrong in ({}, {"end": 1.0, "spring": Spring()}, {"end": 1.0, "extension": 1.0}):
        with pytest.raises(TypeError):
            OF_SPRING(**wrong)


def test_what_has_a_default_may_be_needed():
    table = Table(Spring, needs=["stiffness"])
    with pytest.raises(InputError, match=r"needs the key 'stiffness'"):
        table.read({}, PLACE)
    assert table.read({"stiffness": 2}, PLACE) == Spring(2.0)


def test_an_argument_that_does_not_stand_in_the_file_is_given_later():
    part = Table(length, supplied=["spring"]).read({"end": 2}, PLACE)
    assert part == PartialCall(length, {"end": 2.0})
    assert part.of(None, spring=Spring(10)) == 1
    assert Table(Spring).read({}, PLACE) == Spring(), "and what needs none is made at once"
