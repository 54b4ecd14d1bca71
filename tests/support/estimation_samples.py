"""One sample of each public data class of the estimators, for every seed."""

import warnings

import numpy as np
import sympy

from rcac_numeric import estimation, results
from tests.support.estimation_cases import dynamics, linear_case, output

# What runs, and what it warns of.
ESTIMATORS = {
    estimation.Estimator,
    estimation.ModelRefinement,
    estimation.ForwardRegulator,
    estimation.ForwardEstimator,
    estimation.IndirectController,
    estimation.UnobservableWarning,
    estimation.UnidentifiableWarning,
}


def some(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape)


def linear(seed):
    return linear_case(seed)[0]


def python(seed):
    return estimation.NonlinearModel(dynamics, output, 2, 2, 1, l_p=1, scale=1 + abs(some(seed, 3)))


def symbolic(seed):
    x, u, p = sympy.symbols("x u p")
    return estimation.SymbolicModel(
        [p * sympy.sin(x) + sympy.Rational(seed + 1, 7) * u], [x], [x], [u], [p]
    )


def filter_of(seed):
    return estimation.EKF(linear(seed), Q=0.1, R=1 + abs(some(seed)[()]), form="joseph")


def estimates(seed):
    settings = filter_of(seed)
    return estimation.estimate(
        settings, some(seed, 6, 2), some(seed + 1, 6, 2), keep_covariances=True
    )


def jumps(seed):
    filters = [estimation.EKF(linear(seed), Q=q, R=1.0) for q in (0.1, 1.0 + seed)]
    return estimation.IMM(filters, transitions=[[0.9, 0.1], [0.2, 0.8]])


def level(seed):
    return estimation.EKF(estimation.LinearModel(A=1, C=1), Q=1.0, R=1.0 + seed)


def rcmr(seed):
    return estimation.RCMR(
        A=some(seed, 2, 2) / 4, B=[0, 1], D_1=[1, 0.5], C=[[1, 0.5], [0, 1]], E_1=[1, 0.3],
        subsystem=estimation.FIRSubsystem(2), delays=(1, 2), eta_bar=0.1, stack=(0, 1),
    )  # fmt: skip


def run(seed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", estimation.UnidentifiableWarning)
        return estimation.refine(
            rcmr(seed), some(seed, 8), some(seed + 1, 8, 2), some(seed + 2, 8, 2)
        )


def indirect(seed):
    model = estimation.RCMR(A=some(seed) / 4, B=1, D_1=1, C=1, E_1=1, delays=(1,))
    return estimation.IndirectSettings(model, C_r=1, R_1=1, R_2=1, V_1=1, V_2=1 + seed)


def linearisation(seed):
    m = sympy.Symbol("m")
    A_c, D_c = sympy.Matrix([[0, 1], [-1 / m, -5 / m]]), sympy.Matrix([[0], [1 / m]])
    return estimation.repeated_parameters(A_c, D_c, [m], at=[1 + abs(some(seed)[()])], h=0.1)


ESTIMATION_SAMPLES = {
    estimation.LinearModel: linear,
    estimation.NonlinearModel: python,
    estimation.SymbolicModel: symbolic,
    estimation.EKF: filter_of,
    estimation.UKF: lambda seed: estimation.UKF(
        symbolic(seed), Q=0.1, R=1.0, alpha=2.5, beta=seed / 7
    ),
    estimation.IMM: jumps,
    estimation.AdaptiveNoises: lambda seed: estimation.AdaptiveNoises(level(seed), window=2 + seed),
    results.ModeEstimates: lambda seed: estimation.estimate(
        jumps(seed), some(seed, 6, 2), some(seed + 1, 6, 2)
    ),
    results.AdaptedEstimates: lambda seed: estimation.estimate(
        estimation.AdaptiveNoises(level(seed), window=3), some(seed, 6)
    ),
    results.FittedNoises: lambda seed: estimation.fit_noises(level(seed), some(seed, 20)),
    results.NoiseInformation: lambda seed: estimation.noise_information(level(seed), 100),
    results.SmoothedStates: lambda seed: estimation.smooth(
        estimation.EKF(estimation.LinearModel(A=1, C=1), Q=1.0, R=1.0), seed + np.arange(4.0)
    ),
    results.StateEstimates: estimates,
    results.Consistency: lambda seed: estimates(seed).nis_consistency(),
    results.Observability: lambda seed: estimates(seed).observability,
    estimation.FIRSubsystem: lambda seed: estimation.FIRSubsystem(
        1 + seed, strictly_proper=bool(seed % 2)
    ),
    estimation.RepeatedParameters: lambda seed: linearisation(seed).subsystem,
    results.Linearisation: linearisation,
    estimation.RCMR: rcmr,
    results.RefinementRun: run,
    estimation.IndirectSettings: indirect,
    results.Evidence: lambda seed: run(seed).evidence,
}
