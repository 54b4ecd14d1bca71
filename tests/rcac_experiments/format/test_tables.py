"""What is new is one class and one line: its keys, errors, schema and words follow."""

from typing import Annotated, Literal

import attrs
import pytest

from compensator_theory import InputError
from rcac_experiments.files._reference import kind_keys_table, kinds_table
from rcac_experiments.files._schema import strict_schema
from rcac_experiments.files._structures import STRUCTURES, StructureKind
from rcac_experiments.format._places import Place
from rcac_experiments.format._tables import Kinds, Table, form_of
from rcac_experiments.format._values import Integer, Numbers
from rcac_numeric import Structure, Tap
from rcac_numeric.arrays._array_types import Array

PLACE = Place("case.toml", "controller")


@attrs.frozen
class Spread(StructureKind):
    """Every second lag of y, or as you like."""

    n_c: int
    spacing: Annotated[int, Integer(1), "Steps from one lag to the next."] = 2
    memory: Annotated[Literal["long", "short"], "How much of it."] = "long"

    def of(self, plant):
        taps = [Tap("y", 0, k) for k in range(1, self.n_c + 1, self.spacing)]
        return Structure(taps, 1, 1, self.n_c)


ALL = Kinds({**STRUCTURES.kinds, "spread": Spread}, default="iir")


@attrs.frozen
class Controller:
    """A controller."""

    structure: Annotated[StructureKind, ALL]


TABLE = Table(Controller)


def read(**table):
    return TABLE.read(table, PLACE).structure


def test_it_is_read():
    assert read(structure="spread", n_c=5) == Spread(n_c=5), "as Python would say it"
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
    said = str(error.value)
    for part in ("n_c must be an integer", "spacing = 0", "memory = 'lnog'", "sets 'terms'"):
        assert part in said


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

    with pytest.raises(TypeError, match=r"no form is known .* for matrix"):
        Table(Odd).keys  # noqa: B018


def test_an_array_is_numbers_whatever_numpy_makes_of_its_types():
    assert isinstance(form_of(Array), Numbers)
    assert isinstance(form_of(Array | None), Numbers)
