"""The same answers under each of SymPy's ground types, which a program may have set before."""

import os
import subprocess
import sys

import pytest

CALLS = """
import sympy
from sympy.external.gmpy import GROUND_TYPES
import compensator_theory as e

print(e.place_poles("1/(s*(s + a))", ["-1", "-2", "-3"], feedback=-1, variable="s").compensator)
print(e.resultant("s**2 + a*s + b", "c*s + 1", variable="s"), e.resultant("s**2 + 1/3", "s + 2"))
print(e.stability_intervals("(k**2 - 2)*s**3 + (k + 1)*s + 1", "k"))
print(e.stability_region("s*(s + 1)**3 + k_p*s + k_i", "k_p", "k_i"))
print(e.solve_riccati([[0, 1], [0, 0]], [[0], [1]], Q=[[1, 0], [0, 0]], R=[[1]], time="continuous"))
print(e.lqg_controller(e.standard_problem("(q - 2)/(q**2 - 1/4)")))
print(e.regulator_gain([[-1, 4], [0, -3]], [[0], [1]], [-5, -4]))
print(e.regulator_gain([["a", 4], [0, -3]], [[0], [1]], [-5, -4]))
smith_form = e.forms.smith_form
print(smith_form([["s", "a"], [0, "s"]]), smith_form([["s**2", "s"], ["s", "1/2"]]))
print(e.mcmillan_degree([["1/(s + a)", "1/(s + b)"]], "s"))
print(e.exceptional_cases(e.is_controllable, [[0, 0], [0, 1]], [["a"], [1]]))
print(e.brunovsky_form([["a", 1], [0, "b"]], [[0], [1]]).T)
print(e.sampling.zero_order_hold("1/((s + 1)*(s + 2))").transfer_function)
print(e.gramians("1/(s**2 + a*s + b)", "s").norm_squared)
print(e.is_controllable([[1, 2], [0, 3]], [[1], [1]]))
print(e.transmission_zeros([["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]))
print(e.polynomial_from_roots(["-1 + 2*I", "-1 - 2*I", "sqrt(2)"], "s"))
"""


def answers(ground_types):
    """What the calls print in a process of its own."""
    environment = {**os.environ, "SYMPY_GROUND_TYPES": ground_types}
    done = subprocess.run(
        [sys.executable, "-c", CALLS], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.costly
@pytest.mark.parametrize("ground_types", ["python", "gmpy"])
def test_answers_do_not_depend_on_the_ground_types(ground_types):
    """Of flint's numbers none may reach SymPy as an exponent or a coefficient of another kind."""
    assert answers(ground_types) == answers("flint")
