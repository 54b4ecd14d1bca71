"""What shows a result is found through one table, whose entries are what they say."""

import subprocess
import sys

import pytest

import rcac_numeric
from compensator_theory.errors import InputError
from rcac_numeric.arrays import _showing as showing
from rcac_numeric.reports import _displays as displays
from tests.support.displays import entries_of, standing_of

test_an_entry_takes_the_type_that_it_stands_for = entries_of(displays)
test_every_result_that_asks_the_table_stands_in_it = standing_of(
    ("compensator_theory", "rcac_numeric"), displays
)


def test_what_is_derived_is_shown_like_its_base():
    class Derived(rcac_numeric.results.LoopHealth):
        pass

    health = Derived(True, 0.5, "completed", 10, 0, {})
    assert showing.sheet_of(health).health[0].words.startswith("The closed loop is stable")


@pytest.mark.parametrize(
    "ask", [showing.picture_of, showing.sheet_of, showing.report_of, showing.notebook_of]
)
def test_what_has_no_entry_is_refused_by_its_type(ask):
    with pytest.raises(InputError, match="a complex cannot be shown"):
        ask(1j)


@pytest.mark.costly
def test_a_report_loads_no_matplotlib_and_a_picture_no_user_of_the_library():
    code = """if True:
        import sys
        from rcac_numeric import Compensator, check_controller
        gain = Compensator(past_u=[[[0.0]]], past_y=[[[0.5]], [[0.0]]])
        check = check_controller([0.5, 1.0], [1.0, 2.0], compensator=gain)
        check.report()
        assert "matplotlib" not in sys.modules
        check.plot()
        assert "matplotlib" in sys.modules
        print(*{name.partition(".")[0] for name in sys.modules})
    """
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    packages = {"compensator_theory", "rcac_numeric", "rcac_experiments"}
    assert packages & set(done.stdout.split()) == {"compensator_theory", "rcac_numeric"}
