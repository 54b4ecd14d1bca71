"""One strategy for each public data class: what pickling and printing are tested with."""

import sympy
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory import results
from compensator_theory.strategies import (
    compensators,
    coprime_pairs,
    matrices,
    minimal_plants,
    nonzero_rationals,
    polynomials,
    rationals,
    spectra,
    standard_problems,
    strictly_proper_plants,
)

SIGNS = st.sampled_from([1, -1])
SYMBOLS = st.sampled_from(["a", "k_1"]).map(sympy.Symbol)
POLYS = polynomials()
SYMBOLIC_POLYS = st.builds(
    lambda p, a: exact.polynomial(p.as_expr() + a * p.gen + a**2, "s"), POLYS, SYMBOLS
)


@st.composite
def placements(draw):
    plant = draw(strictly_proper_plants(max_order=2))
    n_c = plant.order + draw(st.integers(0, 1))
    roots = draw(spectra(plant.order + n_c))
    excess = draw(st.sampled_from([None, n_c]))
    return exact.place_poles(plant, roots, feedback=draw(SIGNS), numerator_degree=excess)


@st.composite
def symbolic_placements(draw):
    plant = exact.transfer_function(f"b/(s + {draw(SYMBOLS)})", "s")
    return exact.place_poles(plant, ["-1", draw(rationals())], feedback=draw(SIGNS))


@st.composite
def observer_based(draw):
    plant = draw(minimal_plants(2))
    spectrum = spectra(plant.n)
    return exact.observer_based_compensator(plant, draw(spectrum), draw(spectrum))


EXCEPTIONAL_CASES = st.sampled_from(["1", "s - c", "c*s**2 + 1"]).map(
    lambda right: exact.exceptional_cases(
        exact.solve_diophantine, "s**2 - a", "s - b", right, variable="s"
    )
)


def loops(order=1, hidden=()):
    return st.tuples(minimal_plants(1), compensators(order, hidden=hidden))


def forms(order=1):
    return loops(order).map(lambda pair: exact.observer_forms(*pair))


def first_form(forms):
    return (*forms.forms, *forms.families)[0]


CONTINUUM = (([[0]], [[1]], [[1]]), ([[-2, 0], [0, -2]], [[1], [0]], [[1, 0]]))


@st.composite
def discrete_problems(draw):
    """Scalar plants without zeros on the unit circle, rational or not."""
    b = draw(st.sampled_from(["q - 2", "q - 1/3", "q**2 - 3*q + 1"]))
    return exact.standard_problem(f"{draw(nonzero_rationals())}*({b})/(q**3 - q/{5})", "q")


def continuous_problems():
    """Integrators with costs that give rational and irrational gains."""
    return st.sampled_from([1, 2, "1/3"]).map(
        lambda e: exact.StandardProblem(
            [[0, 1], [0, 0]],
            [[0], [1]],
            [[1, 0]],
            [[0, 0], [e, 0]],
            None,
            [[0, 1]],
            [[e, 0], [0, 0]],
            [[0], ["1/2"]],
            None,
            "s",
        )
    )


@st.composite
def transfer_matrices(draw):
    return draw(standard_problems(max_order=2)).G_zu


INTERVALS = nonzero_rationals().map(
    lambda b: exact.stability_intervals(f"s**3 + s + k + ({b})", "k")
)
PARITIES = strictly_proper_plants().map(exact.decide_strong_stabilisability)
RESPONSES = strictly_proper_plants().map(exact.step_response) | st.just(
    exact.step_response("a/(z**2 + b)", "z")
)
EXPANSIONS = strictly_proper_plants().map(exact.partial_fractions)

MARGINS = st.sampled_from(["10", "100", "1"]).map(
    lambda gain: exact.stability_margins(f"{gain}/(s*(s + 1)*(s + 5))", feedback=-1)
)
DELAYED = st.builds(
    exact.DelayedTransferFunction,
    strictly_proper_plants(),
    st.sampled_from(["1/3", "2"]) | SYMBOLS,
)
STABLE_MARGINS = MARGINS.filter(lambda margins: margins.is_stable)
LOCI = st.sampled_from(["1/(s*(s + 1)*(s + 2))", "(s + 2)/(s**2 + 2*s + 3)"]).map(
    lambda loop: exact.root_locus(loop, feedback=-1)
)
DELAYS = st.sampled_from([["s", "1"], ["s**2 + 4", "-1"], ["s**2 + 2*s + 5", "4"]]).map(
    exact.stability_delays
)

DESCRIPTORS = SYMBOLS.map(
    lambda a: exact.DescriptorSystem(
        [[1, 0, 0], [0, 0, a], [0, 0, 0]],
        [[a, 0, 1], [0, 1, 0], [0, 0, 1]],
        [[1], [0], [a]],
        [[1, 1, 0]],
    )
)
STATE_SPACES = st.builds(
    lambda plant, a: plant if a is None else
    exact.Realisation([[0, a], [0, 0]], [[0], [1]], [[1, 0]], variable="q"),
    minimal_plants(2, "z"), st.none() | SYMBOLS
)  # fmt: skip

POLYNOMIAL_MATRICES = st.builds(
    lambda p, q, a: exact.polynomial_matrix([[p.as_expr(), a], [0, q.as_expr()]], "s"),
    polynomials(max_degree=2), polynomials(max_degree=2), SYMBOLS | st.just(0)
)  # fmt: skip

ZEROS = STATE_SPACES.map(exact.output_decoupling_zeros) | st.sampled_from(
    ["(s + a)/(s**2 + b)", "(s**2 + 2)/(s + 1)", "3"]
).map(lambda text: exact.transmission_zeros(text, "s"))

PAIR = ([[0, 1, 0], [0, 0, 0], [0, 0, 1]], [[0, 0], [1, 0], [1, "a"]])

FAMILIES = st.builds(
    lambda plant, sign: exact.stabilising_compensators(
        plant, [-1], [-2], variable="s", feedback=sign),
    st.sampled_from(["1/(s - 1)", "2*s/(s + 3)", "1/(s - a)"]), SIGNS
)  # fmt: skip

UNSTABLE = st.sampled_from(["(s - 2)/(s**2 - 1)", "1/s", "(s - 1)/(s*(s - 2))"])
REGIONS = nonzero_rationals().map(
    lambda c: exact.stability_region(f"s**2 + a*s + b*({c})", "a", "b")
)

SAMPLES = {
    results.MatrixSolution: matrices(2, 2).map(lambda A: exact.solve_stein(A / 7, [[1, 0], [0, 1]]))
    | st.just(exact.solve_sylvester([["a"]], [["-a"]], [[0]])),
    results.Gramians: st.sampled_from(["1/(s + 1)", "1/(s**2 + a*s + b)", "(z + 1)/(z - 1/2)"]).map(
        lambda text: (
            exact.gramians(text, text[3] if text[3] == "z" else None)
            if text[0] == "("
            else exact.gramians(text, "s")
        )
    ),
    results.RegulatorSolution: SYMBOLS.map(
        lambda a: exact.solve_regulator_equations(f"1/(s + {a})", [[0]], [[-1]])
    ),
    results.ControlledInvariantSubspaces: STATE_SPACES.map(
        exact.geometry.controlled_invariant_subspaces
    ),
    results.DisturbanceDecoupling: st.sampled_from([[[1], [0]], [[0], [1]]]).map(
        lambda E: exact.geometry.decouple_disturbance(
            ([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), E, variable="s"
        )
    ),
    results.FixedModes: minimal_plants(2).map(
        lambda plant: exact.geometry.decentralised_fixed_modes(plant, [([0], [0])])
    ),
    results.Decoupling: strictly_proper_plants(max_order=2).map(exact.geometry.decouple),
    results.Interactor: strictly_proper_plants(max_order=2).map(exact.geometry.interactor)
    | st.just(exact.geometry.interactor("a/(s + 1)", "s")),
    results.HInfinityNorm: st.sampled_from(
        ["1/(s + 1)", "(s + 1)/(s**2 + s + 2)", "z/(z - 1/3)"]
    ).map(exact.h_infinity_norm),
    results.RealnessDecision: st.sampled_from(["1/(s + 1)", "s", "-s", "2/(s + 1)"]).map(
        exact.decide_positive_real
    ),
    results.JordanForm: st.sampled_from(["rational", "real", "complex"]).map(
        lambda over: exact.forms.jordan_form([[0, 1, 0], [-5, -2, 1], [0, 0, 3]], over=over)
    ),
    results.FrobeniusForm: st.sampled_from([[[1, 0], [0, 1]], [["a", 1], [0, 0]]]).map(
        exact.forms.frobenius_form
    ),
    results.KroneckerForm: matrices(2, 2).map(
        lambda A: exact.forms.kronecker_form(A, [["a", 0], [0, 0]])
    ),
    results.PadeApproximant: nonzero_rationals().map(
        lambda c: exact.interpolation.pade_approximant([1, c, "a"], 1, 1)
    ),
    results.PartialRealisation: nonzero_rationals().map(
        lambda c: exact.interpolation.partial_realisation([1, c, "a", 0], "z")
    ),
    results.LaurentExpansion: strictly_proper_plants().map(
        lambda plant: exact.interpolation.laurent_expansion(plant, "a", 2)
    ),
    results.PickInterpolation: nonzero_rationals().map(
        lambda w: exact.interpolation.nevanlinna_pick([1, 2], [w, 1], 3)
    ),
    results.IntervalStability: rationals().map(
        lambda c: exact.decide_interval_stability([1, (c, c + 1), 2])
    ),
    results.StabilityRegion: REGIONS,
    results.StabilitySlab: REGIONS.map(lambda margins: margins.slabs[0]),
    results.StableCompensator: UNSTABLE.map(lambda G: exact.stable_compensator(G, feedback=-1)),
    results.SimultaneousStabilisability: UNSTABLE.map(
        lambda G: exact.decide_simultaneous_stabilisability(G, "1/(s + 1)", feedback=-1)
    ),
    results.MatrixPlacement: spectra(2).map(
        lambda roots: exact.place_matrix_poles(
            [["1/(s - a)"]], [roots], 1, variable="s", feedback=-1
        )
    ),
    results.Subresultants: coprime_pairs().map(lambda pair: exact.bezout.subresultants(*pair))
    | st.just(exact.bezout.subresultants("s**2 + a", "s + 1", variable="s")),
    results.NullSpaceGCD: coprime_pairs().map(lambda pair: exact.bezout.gcd_from_null_space(*pair))
    | st.just(exact.bezout.gcd_from_null_space("s*(s + a)", "s + a", variable="s")),
    results.StabilisingCompensators: FAMILIES,
    results.DoublyCoprimeFractions: FAMILIES.map(lambda margins: margins.fractions),
    results.AffineMap: FAMILIES.map(lambda margins: margins.closed_loop_map()),
    results.BrunovskyForm: st.just(exact.brunovsky_form(*PAIR)),
    results.StateFeedbackFamily: spectra(3).map(lambda p: exact.state_feedback_family(*PAIR, p)),
    results.ObserverGainFamily: spectra(2).map(
        lambda p: exact.observer_gain_family([[0, 1], [0, 0]], [[1, 0]], p)
    ),
    results.FunctionalObserver: spectra(1).map(
        lambda p: exact.reduced_order_observer("1/(s**2 + s)", p)
    ),
    results.Eigenstructure: st.just(
        exact.assign_eigenstructure([[0, 1], [0, 0]], [[0], [1]], ["b", -1], [(1, "b"), (1, -1)])
    ),
    results.DiophantineSolution: st.builds(
        lambda pair, c: exact.solve_diophantine(*pair, c), coprime_pairs(), POLYS
    )
    | st.just(exact.solve_diophantine("s - a", "s - b", "1", variable="s")),
    results.MinimalBasis: POLYNOMIAL_MATRICES.map(exact.forms.minimal_basis)
    | st.just(exact.forms.minimal_basis([["s - a", "s - b"]], "s")),
    results.MatrixDiophantineSolution: POLYNOMIAL_MATRICES.map(
        lambda P: exact.solve_matrix_diophantine(P, [["s", 0], [0, "s + 7"]], P, variable="s")
    ),
    results.StabilityIntervals: INTERVALS,
    results.StabilityCell: INTERVALS.map(lambda margins: margins.cells[0]),
    results.StrongStabilisability: PARITIES,
    results.UnstableRealZero: PARITIES.map(lambda margins: margins.zeros[-1]),
    results.SampledPlant: st.sampled_from(["1/(s + 1)", "1/s**2", "2/((s + 1)*(s + 2))"]).map(
        exact.sampling.zero_order_hold
    )
    | st.just(exact.sampling.zero_order_hold("b/(s*(s + a))", "h", variable="s")),
    results.EnclosedStabilityMargins: st.sampled_from(["1/(s + 1)", "3/(s*(s + 1))"]).map(
        lambda text: exact.stability_margins(
            exact.sampling.zero_order_hold(text, "1/10"), feedback=-1
        )
    ),
    results.EnclosedHInfinityNorm: st.sampled_from(["exp(-1)/(s + 1)", "1/(z - exp(-1))"]).map(
        exact.h_infinity_norm
    ),
    results.InverseSampling: st.sampled_from(
        ["1/(z - 1/2)", "1/(z - 1)**2", "(z + 3)/(z**2 - z + 1)", "1/(z - x)"]
    ).map(lambda text: exact.sampling.inverse_zero_order_hold(text, "h", variable="z")),
    results.Zeros: ZEROS,
    results.ZeroDirection: st.sampled_from(["(s + a)/(s**2 + b)", "(s**2 + 2)/(s + 1)"]).map(
        lambda text: exact.transmission_zeros(text, "s").directions[0]
    ),
    results.Equivalence: st.sampled_from(
        [
            exact.forms.smith_form,
            exact.forms.hermite_form,
            exact.forms.row_reduced_form,
            exact.forms.popov_form,
        ]
    ).flatmap(POLYNOMIAL_MATRICES.map),
    results.CoprimeFractions: transfer_matrices().map(exact.coprime_fractions)
    | st.just(exact.coprime_fractions("(s + a)/(s**2 + b)", "s")),
    exact.results.PolynomialMatrix: POLYNOMIAL_MATRICES,
    results.SmithMcMillanForm: transfer_matrices().map(exact.forms.smith_mcmillan_form),
    results.KalmanDecomposition: STATE_SPACES.map(exact.kalman_decomposition),
    results.MinimalRealisation: STATE_SPACES.map(exact.minimal_realisation)
    | transfer_matrices().map(exact.minimal_realisation),
    results.TimeResponse: RESPONSES,
    results.Mode: RESPONSES.map(lambda y: y.terms[0]),
    results.TransitionMatrix: matrices(2, 2).map(exact.transition_matrix)
    | st.just(exact.transition_matrix([[0, "w"], ["-w", 0]])),
    results.RootFormula: SYMBOLS.map(
        lambda a: exact.transfer_function(f"1/(s**2 + {a}*s + 1)", "s").poles()[0]
    ),
    results.RouthArray: polynomials(min_degree=1).map(exact.routh_array)
    | st.just(exact.routh_array("s**3 + a*s**2 + b*s + c")),
    results.JuryArray: polynomials("z", min_degree=1).map(exact.jury_array)
    | st.just(exact.jury_array("z**2 + a*z + b")),
    results.PartialFractions: EXPANSIONS,
    results.PartialFraction: EXPANSIONS.map(lambda margins: margins.terms[0]),
    exact.results.Certificate: minimal_plants().map(
        lambda plant: plant.transfer_function().certificate
    ),
    exact.Budget: st.builds(exact.Budget, degree=st.integers(1, 10**6)),
    results.BezoutIdentity: st.builds(lambda pair: exact.bezout_identity(*pair), coprime_pairs())
    | st.just(exact.bezout_identity("s + a", "s**2 + b", variable="s")),
    exact.results.Enclosure: st.builds(exact.results.Enclosure, rationals(), rationals().map(abs)),
    results.ExceptionalCases: EXCEPTIONAL_CASES,
    results.ExceptionalCase: EXCEPTIONAL_CASES.map(lambda margins: margins.cases[-1]),
    results.LQGController: (discrete_problems() | continuous_problems()).map(exact.lqg_controller),
    results.ZeroDirectionTarget: nonzero_rationals().map(
        lambda a: exact.zero_direction_target([[1, 0], [a, 1]], [(a + a / abs(a), [1, a])])
    ),
    results.HighAuthorityTarget: discrete_problems().map(exact.high_authority_target),
    results.HighAuthorityLimits: continuous_problems().map(exact.high_authority_limits),
    results.HighAuthorityLimit: continuous_problems().map(
        lambda plant: exact.high_authority_limits(plant).regulator
    ),
    results.ButterworthPattern: continuous_problems().map(
        lambda plant: exact.high_authority_limits(plant).estimator.patterns[0]
    ),
    results.RegulatorLocus: strictly_proper_plants().map(
        lambda plant: exact.regulator_locus(plant.numerator, plant.denominator)
    ),
    results.LQGPoles: (discrete_problems() | continuous_problems()).map(exact.lqg_poles),
    results.ObserverBasedCompensator: observer_based(),
    results.PredictiveCostCompensator: st.sampled_from(
        [("1/(q - 2)", 1, "u"), ("(q + 3)/(q**2 - q/2)", 2, "moves"), ("b/(q - a)", 1, "moves")]
    ).map(lambda of: exact.predictive_cost_compensator(of[0], horizon=of[1], weighs=of[2])),
    results.ObserverDecision: st.builds(
        lambda pair: exact.observers.realisation_is_observer_based(*pair, variable="s"),
        loops(1) | loops(2) | loops(1, ("unobservable",)) | st.just(CONTINUUM),
    ),
    results.Judgement: st.sampled_from(
        [exact.teaching.judge("6.1", lambda k, end=end: 0 < k < end) for end in (0, 6, 9)]
    ),
    results.ObserverForm: st.just(first_form(exact.observer_forms("1/(s - 1)", "-6/(s + 4)"))),
    results.ObserverForms: forms(),
    results.PolePlacement: placements() | symbolic_placements(),
    results.PolynomialEnclosure: st.sampled_from(["q**2 - 3*q + 1", "(q - 2)*(q - 1/2)"]).map(
        lambda text: exact.roots.enclose_split_at_unit_circle(exact.polynomial(text))[0]
    ),
    results.PropositionCheck: coprime_pairs().map(
        lambda pair: exact.bezout.check_proposition_3(*pair, n_c=int(pair[0].degree()), m_hat=0)
    ),
    exact.Realisation: minimal_plants()
    | SYMBOLS.map(lambda a: exact.Realisation([[a]], [[1]], [[a**2 + 1]], variable="q")),
    exact.DescriptorSystem: DESCRIPTORS,
    results.WeierstrassForm: DESCRIPTORS.map(lambda system: system.weierstrass_form()),
    exact.errors.Advice: st.integers(1, 9).map(
        lambda n: exact.errors.Advice(
            "place_poles", (("n_c", str(n)),), "from {function}(n_c={n_c})"
        )
    ),
    results.StabilityMargins: MARGINS,
    results.DelayedStabilityMargins: st.sampled_from(["1", "3/(s - 1)", "5/(s + 1)"]).map(
        lambda plant: exact.stability_margins(f"{plant}*exp(-s/3)/(s + 2)", feedback=-1)
    ),
    results.Margin: STABLE_MARGINS.map(lambda margins: margins.phase),
    results.SymmetricDiskMargin: STABLE_MARGINS.map(lambda margins: margins.disk),
    results.GainCrossover: MARGINS.map(lambda margins: margins.gain_crossovers[0]),
    results.PhaseCrossover: MARGINS.map(lambda margins: margins.phase_crossovers[0]),
    results.RootLocus: LOCI,
    results.LocusBreak: LOCI.map(lambda margins: margins.breaks[0]),
    results.LocusCrossing: LOCI.map(lambda margins: margins.crossings[0]),
    results.LocusAngles: LOCI.map(lambda margins: margins.departures[0]),
    results.StabilityDelays: DELAYS,
    results.DelayCrossing: DELAYS.map(lambda margins: margins.crossings[0]),
    results.RiccatiFormula: st.sampled_from(["continuous", "discrete"]).map(
        lambda time: exact.riccati_formula([["a"]], [[1]], Q=[["q"]], R=[[1]], time=time)
    ),
    results.GainFormula: continuous_problems().map(
        lambda plant: exact.lqg_controller(plant).regulator.formula
    ),
    results.NumberField: continuous_problems().map(
        lambda plant: exact.lqg_controller(plant).regulator.field
    ),
    results.FieldMatrix: continuous_problems().map(
        lambda plant: exact.lqg_controller(plant).estimator.P_in_field
    ),
    results.RiccatiSolution: st.sampled_from([0, 1, "1/4"]).map(
        lambda r: exact.solve_riccati([["3/2"]], [[1]], [[1]], [[r]], time="discrete")
    )
    | continuous_problems().map(lambda plant: exact.lqg_controller(plant).regulator),
    results.Root: polynomials(min_degree=1).map(lambda p: exact.certified_roots(p)[0]),
    results.RootCount: POLYS.map(lambda p: exact.count_roots(p, time="continuous")),
    results.SpectralFactor: st.sampled_from([0, 1, 3]).map(
        lambda r: exact.spectral_factor("z - 2", "z", r, time="discrete")
    )
    | st.sampled_from([0, "1/4", 1]).map(
        lambda r: exact.spectral_factor("s - 1", "s**2", r, time="continuous")
    ),
    results.StabilityDecision: st.builds(
        lambda p, variable: exact.decide_stability(p.replace(p.gen, variable)),
        POLYS | SYMBOLIC_POLYS,
        st.sampled_from(sympy.symbols("s z")),
    ),
    exact.StandardProblem: standard_problems(max_order=2),
    exact.TransferFunction: strictly_proper_plants()
    | SYMBOLIC_POLYS.map(lambda p: exact.transfer_function((1, p * p + 1), "s")),
    exact.DelayedTransferFunction: DELAYED,
    exact.TransferMatrix: transfer_matrices(),
    results.YoulaForm: st.just(
        exact.observers.youla_forms("1/(s - 1)", "-24/(s**2 + 7*s + 18)")[0]
    ),
}
