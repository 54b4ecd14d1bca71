"""One sample of each public data class for every seed: what equality and pickling are tested with.

Different seeds make different data. A new public data class gets a line in `SAMPLES`.
"""

from fractions import Fraction
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

import rcac_numeric as rcac
from rcac_numeric import gallery, identification, results
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.checks._convention_search import search_conventions
from rcac_numeric.checks._conventions import OURS
from rcac_numeric.checks._replays import Replayer
from rcac_numeric.designing._logs import plant_from_log
from rcac_numeric.designing._matrix_logs import MatrixLogSearch
from rcac_numeric.signals._clock import clock_of
from rcac_numeric.signals._signal import Scaled, Sum
from tests.support.equality import SEEDS
from tests.support.estimation_samples import ESTIMATION_SAMPLES


def random(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape)


def fraction(seed):
    """In (0, 1/2], another one for each seed."""
    return Fraction(seed + 1, 2 * SEEDS)


def exact_plant(seed):
    return rcac.standard_plant(f"1/(q - {fraction(seed)})")


def plant(seed):
    M = random(seed, 4, 4) / 4
    return rcac.Plant(
        A=M[:2, :2], B=M[:2, 2:3], D_1=M[:2, 3:], C=M[2:3, :2], D_2=M[2:3, 3:], blocks={"d": 1}
    )


def schedule(seed):
    changes = [
        rcac.PlantChange(start=0, plant=plant(seed)),
        rcac.PlantChange(start=5, plant=plant(seed + 1), state_map=random(seed, 2, 2), delay=2),
    ]
    return rcac.PlantSchedule(changes)


def advance(k, x, u, w):
    """A plant that pickles is made of functions with a name."""
    return 0.5 * x + u + w


def output(k, x, w):
    return x, x


def other_output(k, x, w):
    return x + w, x


def function_plant(seed):
    return rcac.FunctionPlant(
        advance=advance, output=other_output if seed % 2 else output,
        n=1, l_u=1, l_w=1 + seed, l_y=1, l_z=1, blocks={"d": seed, "r": 1},
    )  # fmt: skip


def weight(k, y, z, u):
    return 1.0 + z[0] ** 2


def compensator(seed):
    return rcac.Compensator([[[-0.1 * np.tanh(random(seed)[()])]]], [[[0.0]], [[-0.1]]])


def adapting(seed):
    return rcac.ControllerSettings(
        structure=rcac.iir(1), target=target(seed), update=rcac.UD(1e3),
        theta_0=[0.1, -float(fraction(seed)) / 4],
    )  # fmt: skip


def certified(seed):
    return rcac.certified_set("1/(q - 0.5)", adapting(seed))


def peaks(seed):
    return rcac.peak_bounds(certified(seed), 1.0, share=0.5)


def target(seed):
    return rcac.TargetModel([0.0, *random(seed, 2)], [1.0, 0.0, 0.25])


def exact_target(seed):
    return rcac.target_model(f"(q - 2)/(q**2 - {fraction(seed)})")


def symmetric(seed, size=4):
    root = random(seed, size, size)
    return np.eye(size) + (root @ root.T + (root @ root.T).T) / 2


def structure(seed):
    derived = [
        rcac.DerivedSignal([random(seed)[()]], [1.0], pole=0.5),
        rcac.integral([2.0]),
    ]
    taps = [rcac.Tap("u", 0, 1), rcac.Tap("y", 0, 2)]
    return rcac.Structure([*taps, *(rcac.Tap("derived", i, 1) for i in range(2))], derived=derived)


def settings(seed):
    more = [
        {"update": rcac.Covariance(symmetric(seed), lambda_=scheduled(seed)), "R_u": weight},
        {"update": rcac.Gradient(1e-3), "freeze": [(3, 5), (9, None)]},
        {"update": rcac.SlidingWindow(1.0, window=5), "R_u": rcac.SignalWeight(0.5)},
        {"update": rcac.UD(2.0, reset=reset(seed)), "target_changes": {7: target(seed + 1)}},
        {
            "R_u_unfiltered": 0.5,
            "z_normalization": rcac.Normalization(1.0 + seed),
            "bounds": bounds(seed),
            "fixed": rcac.Compensator([[[0.5]]], [[[0.0]], [[0.25]]]),
        },
    ][seed % 5]
    more = {"update": rcac.UD(1.5), **more}
    return rcac.ControllerSettings(structure=structure(seed), target=target(seed), **more)


def design(seed):
    certain = rcac.Uncertainty(gain=(1, 1), delay=0, time=1, noise=1)
    return rcac.design(f"1/(q - {fraction(seed)})", uncertainty=certain, seeds=2, steps=300)


def answered(seed):
    """u, and the y of a lag with noise."""
    u, v = random(seed, 2, 400)
    return u, lfilter([0, 1], [1, -0.5], u) + 0.01 * v


def stepped(seed):
    """A step of u, and the y of a lag with noise."""
    u = np.repeat([0.0, 1.0], (20, 100))
    return u, lfilter([0, 0, 0.1], [1, -0.9], u) + 0.01 * random(seed, 120)


def logged_matrix(log):
    """The plant of two experiments."""
    search = MatrixLogSearch([log, log], None, 0.0)
    return search.logged(search.search.best)


def bounds(seed):
    return rcac.CoefficientBounds(-1 - seed, [2.0] * 4, gains={"Q": (-3, None)}, sweeps=7)


def ellipsoid(seed):
    return rcac.CertifiedBounds(random(seed, 2), np.tril(random(seed, 2, 2), -1) + np.eye(2))


def adaptive(seed):
    """Settings that everything runs with."""
    update = rcac.UD(1.0 + abs(random(seed)[()]))
    return rcac.ControllerSettings(structure=rcac.iir(1), target=target(0), update=update)


def controller_change(seed):
    change = {"lambda_": 0.9, "R_z": symmetric(seed), "R_u_unfiltered": symmetric(seed, 1)}
    return rcac.ControllerChange(target(seed), **change)


def scheduled(seed):
    return rcac.ScheduledForgetting({1 + seed: 0.9, 3 * SEEDS: 1})


def reset(seed):
    return rcac.CovarianceReset(at=[seed, seed + 2], growth=1.5 + seed, short=3)


def saturation(seed):
    return rcac.Saturation(low=-abs(random(seed)[()]) - 0.1, rate=[2.0])


def run(seed, steps=12):
    options = {"x_0": [0.25], "saturation": saturation(seed)} if seed % 2 else {"stride": 5}
    return rcac.simulate(exact_plant(seed), adaptive(seed), random(seed, steps, 1), **options)


def signals(seed, steps=40):
    return dict(zip("uyzw", random(seed, 4, steps, 1), strict=True))


def log(seed):
    return rcac.ControllerLog(**signals(seed), theta=random(seed + 1, 2), source=f"flight {seed}")


def search(seed):
    replayer = Replayer(log(seed), rcac.iir(1))
    return search_conventions(replayer, replayer.replay(OURS))


def check(seed):
    done = run(2 * (seed // 2), steps=60)
    return rcac.check_controller(
        done.u, done.y, z=done.z, w=done.w, theta=done.theta_final + random(seed, 2) / 50,
        structure=rcac.iir(1), plant=done.plant, target=done.settings.target,
    )  # fmt: skip


def loop(seed):
    return rcac.ClosedLoop(exact_plant(seed), compensator(seed))


def comparison(seed):
    goal = rcac.pole_placement_target(exact_plant(seed), ["1/2", "1/4"])
    return rcac.compare_exactly(exact_plant(seed), compensator(seed), goal)


def observer_forms(seed):
    controller = f"-(4*s + {2 + fraction(seed)})/(s**2 + 4*s + 5)"
    return rcac.observer_forms("1/s**2", controller)


def agreement(seed):
    return replace(
        rcac.lqg_controller(exact_plant(seed % 9)).agreement, coefficient_distance=seed * 1e-20
    )


def two_outputs(seed):
    return rcac.Plant(A=np.diag([0.5, 0.9]), B=random(seed, 2, 1), D_1=[[1], [0]], C=np.eye(2))


def first_order(seed):
    """u and y of a plant without memory of its output, with noise."""
    u = random(seed, 80)
    return u, u - 1.5 * np.r_[0, u[:-1]] + 0.5 * np.r_[0, 0, u[:-2]] + 0.01 * random(seed + 1, 80)


def identified_window(seed):
    return identification.identify_windows(*first_order(seed), mu=5, n_mod=1, order=1)[0]


SAMPLES = {
    **ESTIMATION_SAMPLES,
    # plants
    rcac.Plant: lambda seed: exact_plant(seed) if seed % 2 else plant(seed),
    rcac.PlantChange: lambda seed: schedule(seed).changes[seed % 2],
    rcac.PlantSchedule: schedule,
    rcac.FunctionPlant: function_plant,
    rcac.Saturation: saturation,
    rcac.HealthWarning: lambda seed: rcac.HealthWarning("slow", f"after {seed} steps", "wait"),
    results.LoopHealth: lambda seed: replace(rcac.loop_health(run(seed)), guard_count=seed),
    # signals
    rcac.Step: lambda seed: rcac.Step(random(seed)[()], start=3),
    rcac.Ramp: lambda seed: rcac.Ramp(random(seed)[()], start=seed),
    rcac.Pulse: lambda seed: rcac.Pulse(2, start=1, length=1 + seed),
    rcac.Harmonic: lambda seed: rcac.Harmonic(*random(seed, 3)),
    rcac.WhiteNoise: lambda seed: rcac.WhiteNoise(abs(random(seed)[()])),
    rcac.Levels: lambda seed: rcac.Levels(random(seed, 3), hold=2),
    rcac.FilteredCommand: lambda seed: rcac.FilteredCommand(
        rcac.Step(), omega=0.1 + seed, zeta=0.7, rate=0.5
    ),
    rcac.Piecewise: lambda seed: rcac.Piecewise([(0, rcac.Step()), (1 + seed, rcac.Ramp())]),
    rcac.Recorded: lambda seed: rcac.Recorded(random(seed, 5), f"record {seed}"),
    Sum: lambda seed: rcac.Step(2) + rcac.Harmonic(random(seed)[()]),
    Scaled: lambda seed: random(seed)[()] * rcac.Levels(random(seed, 2)),
    # targets, identification
    rcac.ControllerChange: controller_change,
    results.LearnedTarget: lambda seed: results.LearnedTarget(
        seed, "updated", random(seed, 2) + 0j
    ),
    results.AppliedChange: lambda seed: results.AppliedChange(
        seed, controller_change(seed), "keep", 0.1
    ),
    results.OnlineZeros: lambda seed: results.OnlineZeros(
        1.5 + random(seed, 2) + 0j,
        abs(random(seed, 2)),
        ("undecided",) * 2,
        1,
        1.0,
        0.1,
        4,
        9.0,
        0.5,
    ),
    rcac.DataDriven: lambda seed: rcac.DataDriven(seed=seed),
    rcac.TargetModel: lambda seed: exact_target(seed) if seed % 2 else target(seed),
    rcac.ModellingInformation: lambda seed: rcac.ModellingInformation(1, fraction(seed), [1.5]),
    rcac.targets.DirectionInformation: lambda seed: rcac.targets.DirectionInformation(
        random(seed, 2, 2), [(1.5, random(seed, 2))]
    ),
    results.DirectionCheck: lambda seed: rcac.targets.check_directions(
        rcac.TargetModel(random(seed, 2, 2, 2)),
        rcac.targets.DirectionInformation(random(seed, 2, 2), [(1.5, random(seed, 2))]),
    ),
    results.DirectionsFromData: lambda seed: rcac.identification.directions_from_data(
        random(seed, 40, 1), np.vstack([np.zeros((1, 1)), random(seed, 40, 1)[:-1]]), order=1
    ),
    results.OutputSubspaceZeros: lambda seed: rcac.targets.output_subspace_zeros(two_outputs(seed)),
    results.EigensystemRealisation: lambda seed: identification.eigensystem_realisation(
        [0, *(float(fraction(seed)) ** i for i in range(5))]
    ),
    results.IdentifiedMarkovParameters: lambda seed: identification.identify_markov_parameters(
        signals(seed)["u"], signals(seed)["y"], mu=2, n_mod=1
    ),
    identification.NeweyWest: lambda seed: identification.NeweyWest(lags=seed),
    results.IdentifiedZeros: lambda seed: identified_window(seed).zeros,
    identification.IdentifiedWindow: identified_window,
    results.BootstrapZeros: lambda seed: identification.bootstrap_zeros(
        *first_order(seed), mu=4, n_mod=1, order=1, seed=seed, replicates=3
    ),
    results.DataFact: lambda seed: results.DataFact("sign", "+", 0.9 + 0.01 * seed, 0.95, "of H_1"),
    results.DataTarget: lambda seed: rcac.target_from_data(
        *first_order(seed), mu=5, n_mod=1, order=1
    ),
    # the gallery
    gallery.ContinuousPlant: lambda seed: gallery.ContinuousPlant(
        random(seed, 2, 2), random(seed, 2, 1), random(seed, 1, 2), outputs=[f"y{seed}, V"]
    ),
    results.ZeroPath: lambda seed: gallery.zero_path(schedule(seed), [0, 3]),
    results.OperatingPoint: lambda seed: results.OperatingPoint(random(seed, 2), [seed]),
    gallery.BoostConverter: lambda seed: gallery.BoostConverter(supply=1 + seed),
    gallery.CartPendulum: lambda seed: gallery.CartPendulum(length=1 + seed),
    gallery.MassSpringDamper: lambda seed: gallery.MassSpringDamper(mass=1 + seed),
    # controllers
    rcac.Tap: lambda seed: rcac.Tap("y", 0, seed),
    rcac.DerivedSignal: lambda seed: rcac.DerivedSignal(random(seed, 2), [0, 1], pole=-1.0),
    rcac.Structure: structure,
    rcac.PriorSamples: lambda seed: rcac.PriorSamples(
        100 + seed, y=random(seed, 9), u=random(seed, 9)
    ),
    rcac.UD: lambda seed: rcac.UD(symmetric(seed), process_noise=0.5, stop_where_unsupported=True),
    rcac.Covariance: lambda seed: rcac.Covariance(1 + seed, lambda_=scheduled(seed)),
    rcac.JointUD: lambda seed: rcac.JointUD(1.0, n_d=2, rho=1.0 + seed),
    rcac.SlidingWindow: lambda seed: rcac.SlidingWindow(1.0, window=1 + seed, lambda_=0.5),
    rcac.Instantaneous: lambda seed: rcac.Instantaneous(symmetric(seed)),
    rcac.Gradient: lambda seed: rcac.Gradient(abs(random(seed)[()])),
    rcac.ScheduledForgetting: scheduled,
    rcac.ControlLimits: lambda seed: rcac.ControlLimits(low=-1.0 - seed, rise=0.5),
    rcac.CappedForgetting: lambda seed: rcac.CappedForgetting(float(fraction(seed))),
    rcac.Supervision: lambda seed: rcac.Supervision("bound", growth=2.0 + seed, jump=30),
    results.TroubleCount: lambda seed: results.TroubleCount(3 + seed, 1, 0, 7, 2.0),
    results.SupervisionEvent: lambda seed: results.SupervisionEvent(seed, "windup", 1e7),
    results.SupervisionRecord: lambda seed: results.SupervisionRecord(
        {"jump": results.TroubleCount(3 + seed, 1, 0, 7, 2.0)},
        (results.SupervisionEvent(seed, "jump", 2.0),),
        0.5,
    ),
    rcac.SubspaceForgetting: lambda seed: rcac.SubspaceForgetting(float(fraction(seed))),
    rcac.VariableRateForgetting: lambda seed: rcac.VariableRateForgetting(1, seed + 2, 0.5),
    rcac.CovarianceReset: reset,
    rcac.SignalWeight: lambda seed: rcac.SignalWeight(abs(random(seed)[()]), 0.5),
    rcac.Normalization: lambda seed: rcac.Normalization(1 + seed, 0.5, "erf"),
    rcac.CoefficientBounds: bounds,
    rcac.CertifiedBounds: ellipsoid,
    rcac.ControllerSettings: settings,
    rcac.Decentralized: lambda seed: rcac.Decentralized(
        [adaptive(seed), adaptive(seed + 1)], shared_u=seed % 2 == 0
    ),
    rcac.Compensator: compensator,
    rcac.GainSchedule: lambda seed: rcac.GainSchedule([0, 1 + seed], [compensator(seed)] * 2),
    rcac.PredictiveCost: lambda seed: rcac.PredictiveCost(
        order=2, horizon=3 + seed % 7, problem="servo", limits=rcac.ControlLimits(low=-1 - seed)
    ),
    rcac.FixedController: lambda seed: rcac.FixedController(compensator(seed), l_r=1, k_w=3),
    # engine
    rcac.SimulationCase: lambda seed: rcac.SimulationCase(
        plant(seed), adaptive(seed), random(seed, 5, 1), {"x_0": random(seed, 2), "stride": 2}
    ),
    rcac.Run: run,
    rcac.SavedState: lambda seed: run(seed).state,
    results.ReferenceRun: lambda seed: rcac.simulate_reference(
        plant(seed), adaptive(seed), random(seed, 6, 1), digits=30
    ),
    # analysis
    rcac.ClosedLoop: loop,
    rcac.LoopAnalysis: lambda seed: rcac.LoopAnalysis(
        (exact_plant(seed), compensator(seed)), target(seed)
    ),
    rcac.results.IntercalatedMatch: lambda seed: rcac.intercalated_match(
        loop(seed), target(seed), 9
    ),
    results.ExactComparison: comparison,
    results.PredictiveCostLimit: lambda seed: rcac.predictive_cost_limit(
        rcac.simulate("1/(q - 2)", rcac.PredictiveCost(1, 2, P=1 + seed), np.ones((9, 1)))
    ),
    results.NumericObserverForms: observer_forms,
    results.NumericObserverForm: lambda seed: observer_forms(seed).best_conditioned(),
    results.PlacementConditioning: lambda seed: rcac.placement_conditioning(
        "1/(s - 1)", [-1, -2 - fraction(seed)], feedback=-1
    ),
    results.ResidualSplit: lambda seed: rcac.split_residual(
        exact_plant(seed), compensator(seed), target(seed), **signals(seed)
    ),
    # margins, costs
    results.Margins: lambda seed: rcac.stability_margins(loop(seed)),
    results.DiskMargin: lambda seed: rcac.multivariable_disk_margin(loop(seed)),
    results.CertifiedSet: certified,
    results.CertifiedTail: lambda seed: rcac.certified_from(
        rcac.simulate("1/(q - 0.5)", adapting(seed), random(seed, 20, 1))
    ),
    results.PeakBounds: peaks,
    results.ChannelBound: lambda seed: peaks(seed).proofs[0],
    results.CertifiedMember: lambda seed: certified(seed).members[0],
    results.StabilityBoundary: lambda seed: results.StabilityBoundary(seed, 1, 0.5, 1, np.nan),
    results.H2Cost: lambda seed: rcac.h2_cost(exact_plant(seed), compensator(seed)),
    rcac.LQG: lambda seed: rcac.lqg_controller(exact_plant(seed)),
    results.ExactAgreement: agreement,
    results.ConversionCertificate: lambda seed: results.ConversionCertificate(
        random(seed, 3) * 1j, 1e-15, 1e-14, seed % 3
    ),
    results.ContinuousSolution: lambda seed: rcac.solve_riccati(
        [[1.0 + seed]], [[1.0]], E_1=[[1], [0]], E_2=[[0], [1]], time="continuous"
    ),
    results.StabilisingSolution: lambda seed: rcac.solve_riccati(
        [[2.0]], [[1.0]], [[1.0 + seed]], [[1.0]], time="discrete"
    ),
    # from a plant to a controller
    rcac.Uncertainty: lambda seed: rcac.Uncertainty(gain=(0.5, 2.0 + seed), delay=0),
    results.Design: design,
    results.LoggedPlant: lambda seed: plant_from_log(rcac.ControllerLog(*answered(seed))),
    results.OutputErrorModel: lambda seed: identification.identify_output_error(
        *answered(seed), orders=(1,), delays=(0,)
    ),
    results.ProcessModel: lambda seed: identification.identify_process(*answered(seed)),
    results.ProcessMatrix: lambda seed: identification.identify_process_matrix(*answered(seed)),
    results.LoggedMatrix: lambda seed: logged_matrix(rcac.ControllerLog(*answered(seed))),
    results.Gate: lambda seed: identification.identify_process(*answered(seed)).gates[0],
    results.StepResponse: lambda seed: identification.identify_step_response(*stepped(seed)),
    results.PredictionErrorModel: lambda seed: identification.identify_in_closed_loop(
        *answered(seed), orders=(1,), delays=(0,)
    ),
    # export, streams
    results.Export: lambda seed: results.Export(
        Path("board"), ("README.md", "src/rcac.c"), "float64", 336 + seed, 120, "", "", ("small",)
    ),
    results.BatchRun: lambda seed: rcac.simulate_batch(
        exact_plant(seed), adaptive(seed), random(seed, 3, 20, 1)
    ),
    results.CaseResult: lambda seed: results.CaseResult(seed, "completed", random(seed, 3)),
    # checks
    results.Rounding: lambda seed: results.Rounding("fixed point", 0.5 + seed, "decimals", 4),
    results.Clock: lambda seed: clock_of(0.1 * np.arange(5 + seed), "t"),
    results.LogColumn: lambda seed: results.LogColumn("u", random(seed, 5), unit="V"),
    results.LogContents: lambda seed: rcac.inspect_log({"u": random(seed, 5), "y": random(1, 5)}),
    rcac.ControllerLog: log,
    results.ControlReplay: lambda seed: rcac.replay(log(seed), rcac.iir(1)),
    results.Convention: lambda seed: results.Convention(
        negative_u=bool(seed & 1),
        negative_y=bool(seed & 2),
        y_first=bool(seed & 4),
        is_interleaved=bool(seed & 8),
        oldest_first=bool(seed & 16),
        own_u=bool(seed & 32),
    ),
    results.ConventionMatch: lambda seed: search(seed).closest,
    results.ConventionSearch: search,
    results.SampleShift: lambda seed: results.SampleShift(
        rcac.iir(1 + seed), -1, False, search(seed).closest
    ),
    results.PlantResidual: lambda seed: results.PlantResidual(1.0 + seed, 2.0, 0.5),
    results.ControllerCheck: check,
}
