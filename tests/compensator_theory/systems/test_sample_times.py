"""What is read at a sample time keeps it, whatever is made of it, and goes out with it."""

import dataclasses
import inspect

import control
import numpy as np
import pytest
import scipy.signal
import sympy
import sympy.physics.control as sympy_control
from sympy import Rational

import compensator_theory as c
from compensator_theory import CompensatorError, InputError
from tests.support.public import public_objects

T = 0.01
PERIOD = Rational(1, 100)


def siso(period=T):
    return control.tf([1, 0.5], [1, -0.3, 0.2], period)


def mimo(period=T):
    return control.ss([[0.5, 1], [0, 0.2]], np.eye(2), [[1, 1], [0, 1]], np.zeros((2, 2)), period)


G, P = c.transfer_function(siso()), c.transfer_matrix(mimo())
R, S = c.realisation(mimo()), c.standard_problem(siso())
FAMILY = c.place_poles(G, [0] * 5, 3, feedback=-1)
READERS = [c.transfer_function, c.transfer_matrix, c.realisation]
CONSTRUCTIONS = {
    "sum": G + 1, "from the right": 2 / (G - "1/z"), "power": -(G**-2),
    "reduced": (G / G).reduced(), "subs": ("a" * G).subs({"a": 2}),
    "composed": c.transfer_function("1/(s + 1)").compose(G),
    "dlti": c.transfer_function(scipy.signal.dlti([1], [1, 0.5], dt=T)),
    "zpk": c.transfer_function(scipy.signal.ZerosPolesGain([0.1], [0.5], 2, dt=T)),
    "entry": P[0, 1], "matrix": P, "matrices": (P @ P + P.T - [[1, 0], [0, 1]]) * "z",
    "inverse": P.inverse(), "rows": c.transfer_matrix([[G, "1/z"]]),
    "state space": R, "basis": R.in_basis([[1, 1], [0, 1]]), "dual": R.dual(),
    "series": R @ R - R, "loop": R.feedback_with(R, feedback=-1), "map": R.transfer_matrix(),
    "problem": S, "G_zu": S.G_zu,
    "placement": c.place_poles(G, ["0", "0.1", "0.2"], feedback=-1),
    "family": FAMILY.member([c.exact_number(2)] * len(FAMILY.homogeneous)),
    **{f"{read.__name__} of a text": read("1/(z - 2)", sample_time=T) for read in READERS},
}  # fmt: skip


@pytest.mark.parametrize("name", CONSTRUCTIONS)
def test_the_sample_time_is_kept_and_goes_out(name):
    built = CONSTRUCTIONS[name]
    assert getattr(built, "sample_time", PERIOD) == PERIOD
    assert getattr(built, "time", "discrete") == "discrete"
    assert built.to_control().dt == T
    assert built.to_control(0.1 * 0.1).dt == 0.1 * 0.1  # 0.010000000000000002
    with pytest.raises(InputError, match=r"sampled every 0\.01 s, not every 0\.5 s; leave dt out"):
        built.to_control(0.5)


def test_sampling_says_the_period_of_what_it_makes():
    assert c.sampling.zero_order_hold("1/s", "1/10").realisation.to_control().dt == 0.1
    assert c.sampling.zero_order_hold("1/s").realisation.sample_time is None


def test_what_has_no_sample_time_is_discrete_or_continuous_as_its_variable_says():
    assert c.transfer_matrix([["1/s", 0]]).to_control().dt == 0
    assert c.realisation("1/s").to_control().dt == c.standard_problem("1/s").to_control().dt == 0
    assert c.realisation("1/z").to_control().dt is True
    with pytest.raises(InputError, match="time base of x"):
        c.transfer_matrix([["1/(x + 1)"]]).to_control()
    with pytest.raises(InputError, match="substitute numbers for"):
        c.realisation("a/(s + 1)").to_control()


@pytest.mark.parametrize(
    "join", [lambda: G + c.transfer_function(siso(0.02)), lambda: P @ c.transfer_matrix(mimo(0.02)),
             lambda: R + c.realisation(mimo(0.02)),
             lambda: c.feedback_connection(G, siso(0.02), feedback=-1)],
)  # fmt: skip
def test_two_sample_times_are_not_joined(join):
    with pytest.raises(InputError, match="sampled every 1/100 s and 1/50 s cannot be joined"):
        join()


@pytest.mark.parametrize("construction", [P, R, c.standard_problem(siso())], ids=str)
def test_what_goes_out_has_the_response_of_what_came_in(construction):
    out = construction.to_control()
    for z in np.exp(1j * np.array([0.2, 1.0, 2.5])):
        result = np.atleast_2d(out(z))
        source = (
            mimo()(z)
            if construction is not CONSTRUCTIONS["problem"] and result.shape == (2, 2)
            else None
        )
        if isinstance(construction, c.StandardProblem):
            source = np.full((2, 2), siso()(z))
        np.testing.assert_allclose(result, source, rtol=1e-12)


def test_a_static_gain_goes_out():
    assert c.realisation("3", "z").to_control().D == [[3.0]]


# ---- every public function that takes a system
Q, D = c.observer_based_compensator(G, [0, "1/2"], [0, "1/3"]).compensator, c.standard_problem(G)
K = c.transfer_function("1/(z + 1/4)", sample_time=T)
ALONE = {
    "canonical": G, "closed_loop_polynomial": (D, "1", "z"),
    "closed_loop_transfer_matrix": (D, "1", "z"),
    "closed_loop_zero_polynomial": (D, "1", "z", 0, 0),
    "control_perturbation_transfer_function": (D, "1", "z"),
    "control_perturbation_transfer_matrix": (D, "1", "z"), "controlled_invariant_subspaces": G,
    "coprime_fractions": G, "decentralised_fixed_modes": (R, [((0,), (0,)), ((1,), (1,))]),
    "decide_bounded_real": G, "decide_positive_real": G, "decide_strong_stabilisability": G,
    "decouple": (R, ["z", "z"]), "decouple_disturbance": (G, [[0], [1]]),
    "descriptor_realisation": G, "doubly_coprime_fractions": (G, [0, 0], [0, 0]),
    "functional_observer": (G, [[1, 0]], [0]), "gramians": G, "h_infinity_norm": G,
    "hankel_matrix": (G, 2, 2), "high_authority_target": D, "input_decoupling_zeros": G,
    "interactor": R, "intercalated_transfer_function": (D, "1", "z"),
    "intercalated_transfer_matrix": (D, "1", "z"), "invariant_zeros": G,
    "impulse_response": G, "kalman_decomposition": G, "laurent_expansion": (G, 0, 3),
    "lqg_controller": D, "lqg_poles": D,
    "lqg_problem": (R, *[np.eye(2, dtype=int)] * 4), "markov_parameters": (G, 3),
    "mcmillan_degree": G, "minimal_realisation": G,
    "observer_based_compensator": (G, [0, 0], [0, 0]), "output_decoupling_zeros": G,
    "partial_fractions": G, "place_matrix_poles": (P, [[0, 0, 0]] * 2, 2),
    "place_poles": (G, [0, 0, 0]), "predictive_cost_compensator": (G, [[1, 0]]),
    "realisation": G, "reduced_order_observer": (G, [0]),
    "servo_problem": G, "smith_mcmillan_form": G,
    "solve_regulator_equations": (G, [[1]], [[-1]]),
    "stabilising_compensators": (G, [0, 0], [0, 0]), "stabilising_gains": G,
    "stable_compensator": c.transfer_function("(z - 3)/(z**2 - 4)", sample_time=T),
    "standard_problem": G, "step_response": G, "target_characteristic_polynomial": (D, 2, "1/z"),
    "time_response": (G, "z/(z - 1)"), "transfer_function": G, "transfer_matrix": G,
    "transmission_zeros": G,
}  # fmt: skip
TOGETHER = {
    "closed_loop_matrix": K, "compensator_from_sensitivity": c.sensitivity_function(
        G, K, feedback=-1), "decide_simultaneous_stabilisability": K, "feedback_connection": K,
    "is_lqg_suboptimal": K, "observer_forms": Q, "pair_is_observer_based": K,
    "realisation_is_observer_based": Q, "root_locus": K, "sensitivity_function": K,
    "stabilising_gains": K, "stability_margins": K, "transfer_function_is_observer_based": K,
    "youla_forms": c.transfer_function("1/(z**3 + 1/4)", sample_time=T),
}  # fmt: skip
OF_CONTINUOUS_TIME = {"first_order_hold", "high_authority_limits", "matched", "tustin",
                      "zero_order_hold"}  # fmt: skip
TO_CONTINUOUS_TIME = {"inverse_tustin", "inverse_zero_order_hold"}
DIRECTIONS = {"direction_residual"}  # its G_f is evaluated at a number, whatever time is
PUBLIC = public_objects("compensator_theory")
SYSTEMS = (c.TransferFunction, c.TransferMatrix, c.Realisation, c.DescriptorSystem,
           c.StandardProblem)  # fmt: skip


def called(name, *arguments):
    function = PUBLIC[name]
    sign = {"feedback": -1} if "feedback" in inspect.signature(function).parameters else {}
    if name in ("observer_forms", "realisation_is_observer_based"):
        sign = {}  # that of the compensator
    return function(*arguments, **sign)


def systems_in(result, depth=4):
    """All that a result holds or makes without being asked anything."""
    if isinstance(result, SYSTEMS):
        yield result
    elif depth and isinstance(result, tuple | list):
        for part in result:
            yield from systems_in(part, depth - 1)
    elif depth and dataclasses.is_dataclass(result):
        for name in dir(type(result)):
            if name.startswith("_") or name in ("certificate", "is_verified", "to_control", "plot"):
                continue
            try:
                part = getattr(result, name)
                if inspect.ismethod(part):
                    parameters = inspect.signature(part).parameters.values()
                    if any(one.default is one.empty for one in parameters):
                        continue
                    part = part()
            except CompensatorError:  # no overshoot of a response that settles at 0
                continue
            yield from systems_in(part, depth - 1)
        for one in dataclasses.fields(result):
            yield from systems_in(getattr(result, one.name), depth - 1)


def test_every_public_function_that_takes_a_system_is_below():
    kinds = (*(cls.__name__ for cls in SYSTEMS), "RealisationLike", "LoopPart", "DelayedLike")
    reads = {
        name
        for name, one in PUBLIC.items()
        if inspect.isfunction(one)
        and any(k in str(p.annotation) for p in inspect.signature(one).parameters.values()
                for k in kinds)
    }  # fmt: skip
    assert reads == {*ALONE, *TOGETHER, *OF_CONTINUOUS_TIME, *TO_CONTINUOUS_TIME, *DIRECTIONS}


@pytest.mark.parametrize("name", sorted({*ALONE, *TOGETHER}))
def test_whatever_is_made_of_a_sampled_system_is_sampled(name):
    results = []
    if name in ALONE:
        argument = ALONE[name]
        results.append(called(name, *(argument if isinstance(argument, tuple) else (argument,))))
    if name in TOGETHER:
        results.append(called(name, G, TOGETHER[name]))
    for result in systems_in(results):
        assert (result.sample_time, result.time) == (PERIOD, "discrete")


@pytest.mark.parametrize("name", sorted(TOGETHER))
def test_what_belongs_to_another_time_is_not_joined(name):
    other = TOGETHER[name]
    later = dataclasses.replace(other, sample_time="1/50")
    with pytest.raises(InputError, match="sampled every 1/100 s and 1/50 s cannot be joined"):
        called(name, G, later)
    with pytest.raises(InputError, match=r"in (the variable )?z and .* in s"):
        called(name, G, "1/(s + 1)**3")


@pytest.mark.parametrize("name", sorted(OF_CONTINUOUS_TIME))
def test_what_asks_for_continuous_time_refuses_another_by_name(name):
    with pytest.raises(InputError, match="discrete"):
        called(name, D if name == "high_authority_limits" else G)


@pytest.mark.parametrize("read", READERS)
def test_a_foreign_system_knows_its_time(read):
    for system in (siso(), scipy.signal.dlti([1], [1, 0.5], dt=T), control.tf([1], [1, 2], True)):
        with pytest.raises(InputError, match="not s; leave variable out"):
            read(system, "s")
        assert read(system, "q").time == "discrete"
    for system in (siso(0), scipy.signal.lti([1], [1, 2])):
        with pytest.raises(InputError, match="not z; leave variable out"):
            read(system, "z")
    assert read(control.tf([1], [1, 2], None), "z").time == "discrete"


@pytest.mark.parametrize("read", READERS)
def test_a_sample_time_is_a_positive_number_of_discrete_time(read):
    assert read(siso(), sample_time="0.01") == read(siso())
    assert read("1/z", sample_time=T) != read("1/z")
    for wrong, argument in (("1/s", T), ("1/z", 0), ("1/z", "h"), ("1/x", T), (siso(), 0.02)):
        with pytest.raises(InputError):
            read(wrong, sample_time=argument)


def test_time_is_named_where_the_variable_does_not_show_it_and_has_to_agree_elsewhere():
    for decide in (c.count_roots, c.locate_roots, c.decide_stability, c.spectral_factor):
        assert decide("z - 1/3") == decide("z - 1/3", time="discrete")
        with pytest.raises(InputError, match="z means discrete time"):
            decide("z - 1/3", time="continuous")
        with pytest.raises(InputError, match="x does not show the time domain"):
            decide("x + 2")
    assert c.transfer_function("1/(x + 1)").time is None


# ---- every kind of system, in each of these functions
TEXT = "(z + 1)/(z**2 + z/2 + 1/4)"
NUMERATOR, DENOMINATOR = [1, 1], [1, 0.5, 0.25]
Z = sympy.Symbol("z")
STATES = c.realisation(TEXT)
KINDS = {
    "text": TEXT,
    "expression": c.parse_expression(TEXT),
    "SymPy": sympy_control.TransferFunction(Z + 1, Z**2 + Z / 2 + sympy.Rational(1, 4), Z),
    "python-control": control.tf(NUMERATOR, DENOMINATOR, True),
    "python-control's states": control.ss([[0, 1], [-0.25, -0.5]], [[0], [1]], [[1, 1]], 0, True),
    "SciPy": scipy.signal.dlti(NUMERATOR, DENOMINATOR, dt=1.0),
    "SciPy's states": scipy.signal.dlti(NUMERATOR, DENOMINATOR, dt=1.0).to_ss(),
    "(A, B, C)": STATES.matrices[:3],
    "(A, B, C, D)": tuple(matrix.tolist() for matrix in STATES.matrices),
    "TransferFunction": c.transfer_function(TEXT),
    "TransferMatrix": c.transfer_matrix([[TEXT]]),
    "Realisation": STATES,
    "DescriptorSystem": c.descriptor_realisation(TEXT),
}
BARE = {"(A, B, C)", "(A, B, C, D)"}
FIRST = {
    name: argument[1:] if isinstance(argument, tuple) else ()
    for name, argument in ALONE.items()
    if (argument[0] if isinstance(argument, tuple) else argument) is G
} | {name: ("1/(z + 1/4)",) for name in TOGETHER if name != "compensator_from_sensitivity"}
FIRST |= {
    "compensator_from_sensitivity": ("(z - 1/2)/(z + 1/4)",),
    "youla_forms": ("1/(z**3 + 1/4)",),
}
TIMED = sorted(name for name in FIRST if "variable" in inspect.signature(PUBLIC[name]).parameters)


def result_of(name, system, **options):
    if "feedback" in inspect.signature(PUBLIC[name]).parameters:
        options["feedback"] = -1
    return PUBLIC[name](system, *FIRST[name], **options)


@pytest.mark.parametrize("name", sorted(FIRST))
def test_all_kinds_are_read(name):
    for kind, system in KINDS.items():
        assert result_of(name, system, **({"variable": "z"} if kind in BARE else {})) is not None


@pytest.mark.parametrize("name", TIMED)
@pytest.mark.parametrize("kind", sorted(BARE))
def test_bare_matrices_are_asked_for_their_time(name, kind):
    with pytest.raises(InputError, match=r"time domain.*'s'.*for\s+continuous time"):
        result_of(name, KINDS[kind])


def parameters(name):
    """Those that the functions of the exact half share."""
    for one in PUBLIC.values():
        if inspect.isfunction(one) and name in (ours := inspect.signature(one).parameters):
            yield one.__name__, list(ours).index(name), ours[name]


def test_options_have_one_place():
    """The sign is always written, by name; a variable is second or by name, and evident."""
    for name, _, feedback in parameters("feedback"):
        assert feedback.kind is feedback.KEYWORD_ONLY, name
        assert feedback.default in (feedback.empty, None), name  # None: that of the compensator
    for name, place, variable in parameters("variable"):
        assert variable.kind is variable.KEYWORD_ONLY or place == 1, name
    for shared in ("time", "digits", "sample_time"):
        assert all(one.kind is one.KEYWORD_ONLY for _, _, one in parameters(shared))
