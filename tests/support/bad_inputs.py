"""What no door of the exact half can use, and a call of each door that it can."""

import itertools
from decimal import Decimal
from fractions import Fraction

import numpy as np
import scipy.sparse
import sympy

import compensator_theory as exact
from tests.support.work import Endless, Long

s, a = sympy.symbols("s a")

OBJECTS = [
    object(), None, b"1/s", True, float("nan"), float("inf"), complex("nan"), Decimal("NaN"),
    Decimal("Infinity"), len, int, {1: 2}, [], [[]], [[1, 2], [3]], [None], [float("nan")],
    [[float("inf")]], np.array(3), np.array([[np.nan]]), np.zeros((2, 2, 2)), scipy.sparse.eye(2),
    sympy.Function("f")(s), sympy.MatrixSymbol("A", 2, 2), sympy.Symbol("q", commutative=False),
    sympy.Eq(s, 1), sympy.oo, sympy.nan, sympy.Poly(s + 1, s, modulus=5), sympy.Poly(s * a + 1),
]  # fmt: skip
TEXTS = [
    "", " ", "1/", "((((", "s s", "2s", "s.real", "s[0]", "__import__('os')", "import os",
    "lambda: 1", "nan", "oo", "1/0", "s//2", "s % 2", "f(s)", "exp(s)", "\x00", "s = 1", "1 2",
]  # fmt: skip
LARGE = [
    "1e99999", "9" * 5000, "s+" * 30_000 + "1", "(" * 100 + "s" + ")" * 100, "(s + 1)**100000",
    "s**100000", "(a + b + c + d + s)**60", "(s**2 + 3*s + 9)**600",
    "s*sqrt(2) + sqrt(3) + sqrt(5) + sqrt(7) + sqrt(11)", 10**5000, Fraction(10**5000, 3),
    Decimal("1e100000"), range(10**7), itertools.count(), [0] * 10**6, [[1] * 1000] * 1000,
    [s**100000, 1], [["9" * 5000]], 1 / s**5000, Long(10**7), Endless(),
]  # fmt: skip
BAD = OBJECTS + TEXTS + LARGE

_P, _Q, _G = "s**2 + 3*s + 2", "s + 5", "(s + 5)/(s**2 + 3*s + 2)"
_POLY = exact.polynomial(_P)
_A, _B, _C = [[0, 1], [-2, -3]], [[0], [1]], [[5, 1]]
_R = exact.Realisation(_A, _B, _C, variable="s")
_REALISED = _R
_MATRIX = [["1/(s + 1)", "2/(s + 1)"], ["0", "1/(s + 2)"]]
_SERVO = exact.servo_problem("1/(q**2 - 2*q)")
_CONTINUOUS = exact.StandardProblem(
    A=[[0]], B=[[1]], C=[[1]], D_1=[[1, 0]], D_0=None, D_2=[[0, 1]], E_1=[[2], [0]],
    E_2=[[0], [1]], E_0=None, variable="s",
)  # fmt: skip
_STANDARD = exact.standard_problem("(q - 2)/(q**2 - 1/4)")

GOOD = {
    "bezout_matrix": ([_P, _Q], {}),
    "cauchy_index": ([_Q, _P], {}),
    "gcd_from_null_space": ([_P, _Q], {}),
    "subresultants": ([_P, _Q], {}),
    "solve_diophantine": ([_P, _Q, "s**3"], {}),
    "solve_matrix_diophantine": ([[["s"]], [["s + 1"]], [["s**2"]]], {}),
    "minimal_basis": ([[["s", "1"]]], {}),
    "exceptional_cases": ([exact.solve_diophantine, "s - a", "s - b", "1"], {"variable": "s"}),
    "closed_loop_polynomial": ([_SERVO, "1", "q"], {}),
    "closed_loop_transfer_matrix": ([_SERVO, "1", "q"], {}),
    "closed_loop_zero_polynomial": ([_SERVO, "1", "q"], {}),
    "closed_loop_matrix": ([_REALISED, _REALISED], {"feedback": -1}),
    "feedback_connection": ([_G, "1"], {"feedback": -1}),
    "control_perturbation_transfer_function": ([_SERVO, "1", "q"], {}),
    "control_perturbation_transfer_matrix": ([_SERVO, "1", "q"], {}),
    "intercalated_transfer_function": ([_SERVO, "1", "q"], {}),
    "intercalated_transfer_matrix": ([_SERVO, "1", "q"], {}),
    "target_characteristic_polynomial": ([_SERVO, 2, "-1/q**2"], {}),
    "compensator_from_sensitivity": (
        [_G, "(s**2 + 3*s + 2)/(s**2 + 4*s + 7)"], {"feedback": -1}
    ),
    "sensitivity_function": ([_G, "1"], {"feedback": -1}),
    "direction_residual": ([[["(q - 2)/q**2"]], 2, [1]], {}),
    "zero_direction_target": ([[[1]], [(2, [1])]], {}),
    "lqg_controller": ([_CONTINUOUS], {}),
    "lqg_problem": ([([[0]], [[1]], [[1]]), [[4]], [[1]], [[1]], [[1]]], {"variable": "s"}),
    "high_authority_limits": ([_CONTINUOUS], {}),
    "regulator_locus": (["s - 1", "s**2"], {}),
    "lqg_poles": ([_STANDARD], {}),
    "regulator_spectrum": ([[[3]], [[1]], [[4]], [[0]]], {"time": "discrete"}),
    "solve_riccati": ([[[0]], [[1]], [[4]], [[1]]], {"time": "continuous"}),
    "riccati_formula": ([[[0]], [[1]], [[4]], [[1]]], {"time": "continuous"}),
    "high_authority_target": ([_STANDARD], {}),
    "bezout_identity": ([_P, _Q], {}),
    "number_of_common_roots": ([_P, _Q], {}),
    "resultant": ([_P, _Q], {}),
    "sylvester_m": ([_P, _Q, 1, 1], {}),
    "sylvester_m1": ([_P, _Q], {}),
    "sylvester_m2": ([_P, _Q], {}),
    "count_observer_forms": (["(s + 1)*(s + 2)", 1], {}),
    "observer_based_compensator": ([_R, [-5, -4], [-6, -7]], {}),
    "observer_forms": (["4/((s + 1)*(s + 3))", "-(s + 3)/(s**2 + 13*s + 49)"], {"feedback": 1}),
    "observer_gain": ([_A, _C, [-4, -5]], {}),
    "regulator_gain": ([_A, _B, [-4, -5]], {}),
    "is_lqg_suboptimal": ([_G, "-1/(s + 9)"], {"feedback": 1}),
    "pair_is_observer_based": ([_G, "-1/(s + 9)"], {"feedback": 1}),
    "transfer_function_is_observer_based": ([_G, "-1/(s + 9)"], {"feedback": 1}),
    "realisation_is_observer_based": ([_R, _R], {"feedback": 1}),
    "youla_forms": (["1/(s - 1)", exact.realisation("-24/(s**2 + 7*s + 18)")], {}),
    "place_poles": (["1/(s - 1)", [-1]], {"feedback": -1}),
    "place_matrix_poles": (
        [[["1/(s - 1)", 0], ["1/(s + 2)", "1/(s + 1)"]], [[-1, -2, -3], [-1, -2, -3, -4]], 2],
        {"feedback": -1},
    ),
    "check_proposition_3": ([_P, _Q, 2, 1], {}),
    "check_proposition_4": ([_P, _Q, 2, 1], {}),
    "parse_expression": (["s + 1"], {}),
    "polynomial_from_roots": ([[-1, -2], "s"], {}),
    "read_roots": (["-1, -2"], {}),
    "exact_number": (["1/2"], {}),
    "polynomial": ([_P], {}),
    **{
        name: ([_POLY], {})
        for name in (
            "monic", "certified_roots", "closed_form_roots", "number_of_real_roots",
            "monic_reciprocal_polynomial", "reciprocal_polynomial", "reflection_coefficients",
        )
    },
    "count_roots": ([_POLY], {}),
    "locate_roots": ([_POLY], {}),
    "split_at_unit_circle": ([exact.polynomial("z**2 + 5*z/2 + 1")], {}),
    "enclose_split_at_unit_circle": ([exact.polynomial("z**2 + 3*z + 1")], {}),
    "spectral_factor": (["z - 2", "z", 3], {"time": "discrete"}),
    "decide_stability": ([_P], {}),
    "hurwitz_determinants": ([_P], {}),
    "stability_conditions": (["s**2 + a*s + 1"], {}),
    "stabilising_gains": (["1/(s - 1)"], {"feedback": -1}),
    "stability_intervals": (["s**2 + a*s + 1", "a"], {}),
    "decide_strong_stabilisability": (["(s - 1)/(s**2 - 4)"], {}),
    "brunovsky_form": ([_A, _B], {}),
    "assign_eigenstructure": ([_A, _B, [-4, -5], [[1, -4], [1, -5]]], {}),
    "reachable_eigenvectors": ([_A, _B, -4], {}),
    "state_feedback_family": ([_A, _B, [-4, -5]], {}),
    "observer_gain_family": ([_A, _C, [-4, -5]], {}),
    "functional_observer": ([_R, [[1, 0]], [-4]], {"variable": "s"}),
    "predictive_cost_compensator": (["1/(q - 2)"], {"horizon": 2}),
    "reduced_order_observer": ([_R, [-4]], {"variable": "s"}),
    **{
        name: ([_MATRIX], {})
        for name in (
            "coprime_fractions", "mcmillan_degree", "minimal_realisation", "smith_mcmillan_form",
            "transmission_zeros", "transfer_matrix", "descriptor_realisation",
        )
    },
    "hankel_matrix": ([_MATRIX, 2, 2], {}),
    **{
        name: ([[["s", "1"], ["0", "s"]]], {})
        for name in ("polynomial_matrix", "hermite_form", "row_reduced_form", "smith_form")
    },
    **{
        name: ([_R], {})
        for name in (
            "kalman_decomposition", "input_decoupling_zeros", "invariant_zeros",
            "output_decoupling_zeros", "realisation",
        )
    },
    "doubly_coprime_fractions": ([_R, [-1, -1], [-1, -1]], {"variable": "s"}),
    "stabilising_compensators": (
        [_R, [-1, -1], [-1, -1]], {"feedback": 1, "variable": "s"}
    ),
    "zero_order_hold": ([_R, "h"], {}),
    "matched": ([_R, "h"], {}),
    "inverse_zero_order_hold": (["1/(z - 1/2)", "h"], {}),
    "inverse_tustin": (["1/(z - 1/2)", "1/2"], {}),
    "sampling_zero_polynomial": ([3], {}),
    "canonical": ([_G], {}),
    "controllability_matrix": ([_A, _B], {}),
    "is_controllable": ([_A, _B], {}),
    "uncontrollable_polynomial": ([_A, _B], {}),
    "transfer_function": ([_G], {}),
    "compensator_polynomials": ([[1, "-0.5"], [3, 4], 2, 1], {}),
    "markov_parameters": ([_G, 3], {}),
    "partial_fractions": ([_G], {}),
    "step_response": ([_G], {}),
    "impulse_response": ([_G], {}),
    "time_response": ([_G, "1/s**2"], {}),
    "transition_matrix": ([_A], {}),
    "certificate_record": ([exact.bezout_identity(_P, _Q)], {}),
    "to_coq": ([exact.bezout_identity(_P, _Q)], {}),
    "routh_array": ([_P], {}),
    "jury_array": (["z**2 + a*z + 1/2"], {}),
    "servo_problem": (["1/(q**2 - 2*q)"], {}),
    "standard_problem": (["(q - 2)/(q**2 - 1/4)"], {}),
    "solve_lyapunov": ([_A, [[1, 0], [0, 1]]], {}),
    "solve_stein": ([[[0, 1], [0, "1/2"]], [[1, 0], [0, 1]], [[0, 1], [0, "1/3"]]], {}),
    "solve_sylvester": ([_A, [["a"]], [[1], [0]]], {}),
    "solve_regulator_equations": ([_R, [[0, 1], [-1, 0]], [[-1, 0]], [[1, 0], [0, 1]]], {}),
    "gramians": ([_R, "s"], {}),
    "controlled_invariant_subspaces": ([_R], {}),
    "decouple": ([_R, ["s + 1"]], {}),
    "decouple_disturbance": ([_R, [[0], [1]]], {}),
    "decentralised_fixed_modes": ([_R, [([0], [0])]], {}),
    "interactor": ([_MATRIX], {}),
    "frobenius_form": ([_A], {}),
    "jordan_form": ([[["a", 1], [0, "b"]]], {}),
    "kronecker_form": ([_A, [[1, 0], [0, 0]]], {}),
    "popov_form": ([[["s**2", "s**2 + 1"], ["s", "s"]]], {}),
    "h_infinity_norm": ([_MATRIX], {}),
    "stability_margins": (["1/(s*(s + 1))"], {"feedback": -1}),
    "root_locus": (["1/(s*(s + 1))"], {"feedback": -1}),
    "first_order_hold": (["1/(s + 1)", "1/2"], {}),
    "tustin": (["1/(s + 1)", "1/2"], {}),
    "stability_delays": ([["s", "1"]], {}),
    "decide_bounded_real": ([_MATRIX], {}),
    "decide_positive_real": ([_MATRIX], {}),
    "laurent_expansion": ([_G, -1, 3], {}),
    "nevanlinna_pick": ([[1, 2], [1, [-1, 2]], 5], {}),
    "pade_approximant": ([[1, -1, "1/2", "-1/6", "1/24"], 2, 2], {}),
    "partial_realisation": ([[1, 2, -8, 20]], {}),
    "decide_interval_stability": ([[1, (3, 4), (4, 5), (1, 5)]], {}),
    "stability_region": (["s**3 + 3*s**2 + k_p*s + k_i", "k_p", "k_i"], {}),
    "stable_compensator": (["(s - 2)/(s**2 - 1)", 4], {"feedback": -1}),
    "decide_simultaneous_stabilisability": (["1/(s - 1)", "1/(s - 2)"], {"feedback": -1}),
}  # fmt: skip
_VALUES = [
    -1, 0, 0.5, 1j, "1j", "", [], {}, set(), {1: 1}, [None], [True], ["1"], [-1], [1.0], [1, 1, 1],
    [10**30], 10**30, float("nan"), [float("nan")], sympy.I, sympy.Integer(2), sympy.nan,
    np.array([1, 1]), np.zeros((2, 2)), object(), s, "s", b"1", range(10**7), itertools.count(),
    Long(10**7), Endless(),
]  # fmt: skip
LAST_ARGUMENTS = {
    ("zero_direction_target", "zeros"): [*_VALUES, "2", [2], [(2,)], [("2", "1")], [(2, {1: 1})]],
    ("zero_direction_target", "delays"): [*_VALUES, [1, 1], (0.5,)],
    ("zero_direction_target", "taps"): [*_VALUES, 10**6, [1]],
    ("zero_order_hold", "variable"): [*_VALUES, "z", "q", "2", "a b", sympy.pi],
    ("zero_order_hold", "discrete_variable"): [*_VALUES, "h", "w", "2", "a b", sympy.pi],
    ("zero_order_hold", "step"): [
        *_VALUES, "z", "log(2)", sympy.pi, sympy.sqrt(2), -sympy.log(2), sympy.log(a),
        sympy.log(-1), sympy.log(2) * s, 10**50 * sympy.log(2), 10**50 * sympy.log(6) / 7,
        sympy.log(10**5000), sympy.log(sympy.Rational(1, 2)), sympy.log(2) * sympy.oo,
        sympy.Integral(sympy.log(a), (a, 1, 2)), sympy.log(sympy.AccumBounds(1, 2)),
        sympy.Symbol("h", negative=True), sympy.Symbol("h", commutative=False),
    ],
}  # fmt: skip
"""What an argument with a default cannot use, or barely can: no foreign error, and no long work."""
TEACHING = {
    "check", "judge", "function_exercise", "claim_exercise", "course_exercises", "student_notebook"
}  # fmt: skip
NOT_DOORS = {"strategies", "budget", "ball_precision", *TEACHING}
"""A module of strategies, settings and exercises, which have tests of their own."""
