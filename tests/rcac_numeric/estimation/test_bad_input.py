"""What is wrong with a model, a record or a setting is named, and nothing has moved."""

import numpy as np
import pytest
import sympy

from compensator_theory.errors import (
    DivergedError,
    FunctionFailedError,
    IllConditionedError,
    InputError,
)
from rcac_numeric.estimation import (
    EKF,
    RCMR,
    UKF,
    Estimator,
    FIRSubsystem,
    LinearModel,
    ModelRefinement,
    NonlinearModel,
    RepeatedParameters,
    SymbolicModel,
    UnidentifiableWarning,
    UnobservableWarning,
    estimate,
    nees_consistency,
    nis_consistency,
    observability,
    refine,
    repeated_parameters,
)

X, P, U = sympy.symbols("x p u")
STILL = LinearModel(A=1, C=1)
ONE = {"A": 0.5, "B": 1, "D_1": 1, "C": 1, "E_1": 1}
FLAT = {"A": [[0.5, 1], [0, 0.2]], "D_1": [0, 1], "C": [1, 0], "E_1": [1, 0]}


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: LinearModel(A=[[1, 2]], C=[[1, 2]]), "A has shape"),
        (lambda: LinearModel(A=np.eye(2), C=[[1, 2, 3]]), "C has shape"),
        (lambda: LinearModel(A=np.nan, C=1), "A has the entry nan"),
        (lambda: LinearModel(A=1, C=1, B=[[1, 2]], D=[[1]]), "D has shape"),
        (lambda: NonlinearModel(3, abs, 1, 1), "dynamics = 3 is not a function"),
        (lambda: NonlinearModel(abs, abs, 1, 1, output_jacobian=3), "output_jacobian = 3 is not"),
        (lambda: NonlinearModel(abs, abs, 0, 1), "n_x = 0 must be at least 1"),
        (lambda: NonlinearModel(abs, abs, 1, 1, scale=[0]), "positive numbers"),
        (lambda: SymbolicModel([X * P], [X], [X]), "p has no value"),
        (lambda: SymbolicModel([X], [X], [X], [X]), "x: a symbol occurs twice"),
        (lambda: SymbolicModel([X, X], [X], [X]), "one expression for each state"),
        (lambda: SymbolicModel(["x"], [X], [X]), "'x', which is no SymPy expression"),
        (lambda: SymbolicModel([X], [X], [X**2]), "which is no symbol"),
        (lambda: SymbolicModel([X / sympy.S(0)], [X], [X]), "not a finite real expression"),
        (lambda: SymbolicModel(X, [X], [X]), "must be a list"),
        (lambda: EKF("model", 1, 1), "is no model"),
        (lambda: EKF(STILL, Q=-1, R=1), "Q has the eigenvalue -1"),
        (lambda: EKF(STILL, Q=1, R=np.eye(2)), "R has shape"),
        (lambda: EKF(STILL, Q=1, R=1, P_0=[[-1]]), "P_0 has the eigenvalue -1"),
        (lambda: EKF(STILL, Q=1, R=1, x_0=[1, 2]), "x_0 has 2 entries"),
        (lambda: EKF(STILL, Q=1, R=1, form="plain"), "form = 'plain' is not known"),
        (lambda: UKF(STILL, Q=1, R=1, alpha=0), "alpha = 0 must be positive"),
        (lambda: Estimator("EKF"), "an EKF or a UKF is needed"),
        (lambda: Estimator(EKF(STILL, 1, 1)).step([1, 2]), "y has 2 entries"),
        (lambda: Estimator(EKF(STILL, 1, 1)).step(np.inf), "y has the entry inf"),
        (lambda: Estimator(EKF(STILL, 1, 1)).step(1, u=1), "u has 1 entries where 0"),
        (lambda: Estimator(EKF(LinearModel(1, 1, B=1), 1, 1)).step(1), "u has 0 entries"),
        (lambda: Estimator(EKF(STILL, 1, 1)).step("one"), "y must be an array"),
        (lambda: estimate(EKF(STILL, 1, 1), [[1, 2]]), "y has shape"),
        (lambda: estimate(EKF(STILL, 1, 1), [1, 2], measured=[1, 0]), "one True or False"),
        (lambda: estimate(EKF(LinearModel(1, 1, B=1), 1, 1), [1, 2]), "1 known inputs"),
        (lambda: estimate(EKF(STILL, 1, 1), [1, 2]).nees_consistency([0, 0]), "keep_covariances"),
        (lambda: observability(STILL, np.zeros((0, 1))), "x has no row"),
        (lambda: nis_consistency([], 1), "nis is empty"),
        (lambda: nis_consistency([1], 1, confidence=1), "between 0 and 1"),
        (lambda: nees_consistency([[1, 2]], np.zeros((1, 2, 2))), "not positive definite"),
        (lambda: nees_consistency([1, 2], np.eye(2)), "error has shape"),
        (lambda: RCMR(**ONE | {"B": None}), "needs B"),
        (lambda: RCMR(**ONE, lambda_=0), r"must lie in \(0, 1\]"),
        (lambda: RCMR(**ONE, beta=0), "beta has the eigenvalue 0"),
        (lambda: RCMR(**ONE, delays=(2, 1)), "increasing order"),
        (lambda: RCMR(**ONE, delays=2), "must be a list"),
        (lambda: RCMR(**ONE, delays=(1, 2), d=3), "d = 3 is none of the delays"),
        (lambda: RCMR(**ONE, eta_bar=-1), "must not be negative"),
        (lambda: RCMR(**ONE, method="other"), "method = 'other' is not known"),
        (lambda: RCMR(**ONE, subsystem=RepeatedParameters([[[1]]])), "leave out B and E_1"),
        (lambda: RCMR(1, 1, 1, subsystem=RepeatedParameters([np.eye(2)])), "A_j of size 2"),
        (lambda: FIRSubsystem(0), "n_c = 0 must be at least 1"),
        (lambda: RepeatedParameters([[[0]]]), "occurs neither in A nor in D"),
        (lambda: RepeatedParameters([[1]]), r"\(l_theta, n, n\) is needed"),
        (
            lambda: repeated_parameters(sympy.Matrix([X * P]), sympy.Matrix([1]), [P], [1], 0.1),
            "A_c holds x, which is no parameter",
        ),
        (
            lambda: repeated_parameters(sympy.Matrix([1 / P]), sympy.Matrix([1]), [P], [0], 0.1),
            "A_c",
        ),
        (lambda: ModelRefinement(RCMR(**ONE)).step(1, [1, 2]), "y has 2 entries"),
        (lambda: ModelRefinement(RCMR(**ONE)).step(np.nan, 1), "w has the entry nan"),
        (lambda: ModelRefinement(RCMR(**ONE)).advance(1), "comes after measure"),
        (lambda: refine(RCMR(**ONE), [1, 2], [1]), "w has 2 rows where 1 steps"),
    ],
)
def test_it_is_named(make, says):
    with pytest.raises(InputError, match=says):
        make()


@pytest.mark.parametrize(
    ("choices", "says"),
    [
        ({"B": [0, 1], "delays": (1,)}, "are zero"),
        (
            {"B": [1, 0], "delays": (1, 2), "method": "smallest"},
            r"\(8.56\) is singular: H~ has 2 columns and rank 1",
        ),
    ],
)
def test_a_reconstruction_without_an_answer_is_named(choices, says):
    with pytest.raises(IllConditionedError, match=says):
        RCMR(**FLAT | choices)


def broken(kind, **functions):
    whole = {"dynamics": lambda k, x, u: x, "output": lambda k, x, u: x} | functions
    return Estimator(kind(NonlinearModel(**whole, n_x=1, l_y=1), Q=1, R=1))


def raises(k, x, u):
    raise KeyError("engine")


@pytest.mark.parametrize("kind", [EKF, UKF])
@pytest.mark.parametrize(
    ("functions", "says"),
    [
        ({"dynamics": raises}, "failed at step 0: KeyError: 'engine'"),
        ({"output": raises}, "failed at step 0: KeyError"),
        ({"dynamics": lambda k, x, u: x * np.nan}, r"f\(k, x, u\).* has the entry nan"),
        ({"output": lambda k, x, u: [np.inf]}, r"h\(k, x, u\).* has the entry inf"),
        ({"dynamics": lambda k, x, u: [1, 2]}, "returned 2 numbers where 1 are needed"),
        ({"dynamics": lambda k, x, u: None}, "returned None"),
        ({"dynamics": lambda k, x, u: "much"}, "failed at step 0: ValueError"),
        ({"dynamics": lambda x: x}, "failed at step 0: TypeError"),
    ],
)
def test_a_function_that_fails(kind, functions, says):
    estimator = broken(kind, **functions)
    before = estimator.state
    with pytest.raises(FunctionFailedError, match=says):
        estimator.step(1.0)
    assert np.array_equal(estimator.x, [0]) and np.array_equal(estimator.P, [[1]])
    assert estimator.k == before.k == 0


def test_a_jacobian_that_is_not_finite():
    estimator = broken(EKF, output_jacobian=lambda k, x, u: [[np.nan]])
    with pytest.raises(FunctionFailedError, match="the Jacobian H of h has the entry nan"):
        estimator.step(1.0)
    estimator = broken(EKF, dynamics_jacobian=lambda k, x, u: [[np.inf]])
    with pytest.raises(FunctionFailedError, match="the Jacobian F of f has the entry inf"):
        estimator.step(1.0)


def test_what_was_estimated_before_a_failure_is_kept():
    def fails_later(k, x, u):
        return x if k < 5 else x * np.nan

    settings = EKF(NonlinearModel(fails_later, lambda k, x, u: x, 1, 1), Q=1, R=1)
    with pytest.raises(FunctionFailedError, match="step 5") as caught:
        estimate(settings, np.ones(10))
    assert np.array_equal(caught.value.run.x, estimate(settings, np.ones(5)).x)


@pytest.mark.parametrize("form", ["square root", "joseph"])
def test_a_singular_innovation(form):
    """H P H' + R has the entries 1, exactly: the second pivot of its Cholesky factor is 0."""
    twice = LinearModel(A=1, C=[[1], [1]])
    with pytest.raises(IllConditionedError, match="covariance of the innovation is singular"):
        Estimator(EKF(twice, Q=1, R=0, form=form)).step([1, 1])


def test_a_negative_weight_that_costs_definiteness():
    model = SymbolicModel([X], [sympy.cos(X)], [X])
    with pytest.raises(IllConditionedError, match="lost its definiteness; alpha >= n"):
        Estimator(UKF(model, Q=0, R=0.01, P_0=4, alpha=0.05)).step(1.0)


def test_an_estimate_that_leaves_float64():
    with pytest.raises(DivergedError, match="left the range of float64"):
        estimate(EKF(LinearModel(A=1e10, C=0.0), Q=1, R=1), np.ones(100))


def test_a_refined_model_that_diverges_is_no_longer_used():
    refinement = ModelRefinement(RCMR(**ONE | {"A": 2.0}, theta_0=[2.0], k_update=10**6))
    with pytest.raises(DivergedError, match="free-running model diverged"):
        for _ in range(2000):
            refinement.step(1.0, 0.0)
    with pytest.raises(DivergedError, match="no longer usable"):
        refinement.step(1.0, 0.0)
    with pytest.raises(DivergedError):
        refine(refinement.settings, np.ones(2000), np.zeros(2000))


def test_an_unobservable_state_is_named():
    apart = LinearModel(A=[[0.5, 0], [0, 0.9]], C=[[1, 0]])
    with pytest.warns(UnobservableWarning, match=r"contain no information on x\[1\]:"):
        estimates = estimate(EKF(apart, Q=0.1, R=1), np.ones(30))
    assert len(estimates.observability.unseen) == 1


def test_parameters_that_cannot_be_told_apart_are_named():
    """Only the sum of two gains shows."""
    q = sympy.Symbol("q")
    model = SymbolicModel([X / 2 + U], [X * (P + q)], [X], [U], [P, q])
    u = np.random.default_rng(0).standard_normal(50)
    with pytest.warns(UnobservableWarning, match="on a combination of p, q"):
        estimate(EKF(model, Q=0, R=1, x_0=[0, 1, 1]), u, u)


def test_a_parameter_that_nothing_excites_is_named():
    model = SymbolicModel([P * X], [X], [X], parameters=[P])
    with pytest.warns(UnobservableWarning, match="no information on p:"):
        estimate(EKF(model, Q=0, R=1), np.zeros(20))
    with pytest.warns(UnidentifiableWarning, match="do not determine theta"):
        refine(RCMR(**ONE), np.zeros(20), np.zeros(20))
    with pytest.warns(UnidentifiableWarning, match="do not determine theta"):
        refine(RCMR(**ONE, lambda_=0.9), np.zeros(20), np.zeros(20))


def test_states_of_other_settings_are_refused():
    one, other = Estimator(EKF(STILL, 1, 1)), Estimator(EKF(STILL, 1, 2))
    with pytest.raises(InputError, match="other settings"):
        other.restore(one.state)
    with pytest.raises(InputError, match="cannot be restored from the state of a filter"):
        ModelRefinement(RCMR(**ONE)).restore(one.state)
