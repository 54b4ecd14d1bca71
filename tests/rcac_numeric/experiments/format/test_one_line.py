"""What is new is one function and one line: its keys, errors, schema and words follow."""

import pytest

from compensator_theory import InputError
from rcac_numeric import Structure, Tap
from rcac_numeric.experiments.files.schema import strict_schema
from rcac_numeric.experiments.files.structures import STRUCTURES
from rcac_numeric.experiments.format.markdown import kind_keys_table, kinds_table
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Kinds, Table

PLACE = Place("case.toml", "controller")
GIVEN = ("l_u", "l_y")


def spread(n_c: int, spacing: int = 2, memory: str = "long", l_u: int = 1, l_y: int = 1):
    """Every second lag of y, or as you like.

    Parameters
    ----------
    spacing : int
        Steps from one lag to the next.
    memory : {"long", "short"}
        How much of it.
    """
    return Structure([Tap("y", 0, k) for k in range(1, n_c + 1, spacing)], l_u, l_y, n_c)


def _controller(structure: Structure) -> Structure:
    """A controller."""
    return structure


ALL = Kinds({**STRUCTURES.kinds, "spread": spread}, default="iir", given=GIVEN)
TABLE = Table(_controller, forms={"structure": ALL})


def read(**table):
    return TABLE.read(table, PLACE).build(l_u=1, l_y=1)


def test_it_is_read():
    taps = read(structure="spread", n_c=5).taps
    assert [tap.delay for tap in taps] == [1, 3, 5]
    assert [tap.delay for tap in read(structure="spread", n_c=5, spacing=4).taps] == [1, 5]


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


def test_a_parameter_that_cannot_be_read_is_noticed_where_it_is_declared():
    def odd(matrix: "set[int]") -> Structure:
        """Odd."""

    with pytest.raises(TypeError, match="no form is known for matrix"):
        Table(odd).keys  # noqa: B018
