"""Settings with everything that the stand-alone core knows, and closed loops that drive them."""

import numpy as np
from hypothesis import strategies as st

import rcac_numeric as rn
from rcac_numeric.arrays._values import replaced as replace
from tests.support.engine_cases import engine_plants, positive, settings_for, structures
from tests.support.strategies import seeds


@st.composite
def core_settings(draw, strictly_proper=False, **fixed):
    """(settings, plant) over all structures and options of the core."""
    l_u, l_y, l_z, l_r = (draw(st.integers(least, 2)) for least in (1, 1, 1, 0))
    rng = np.random.default_rng(draw(seeds))
    structure, _ = draw(structures(l_u, l_y, l_r))
    l_r = structure.l_r
    if structure.derived and draw(st.booleans()):
        limited = [rn.DerivedSignal(s.now, s.before, s.pole, 0.5) for s in structure.derived]
        structure = replace(structure, derived=limited)
    size = structure.l_theta
    form = draw(st.sampled_from(["predictor", "predictor", "filter"]))
    noise = draw(st.sampled_from([None, None, 0.01, 1e-3 * positive(rng, size)]))
    lambda_ = draw(
        st.sampled_from(
            [1.0, 1.0, 0.98, rn.ScheduledForgetting({20: 0.95, 60: 1.0}),
             rn.VariableRateForgetting(short=3, long=12, gain=0.3)]
        )
    )  # fmt: skip
    rules = [
        None, None, rn.CovarianceReset(at=[30, 55]), rn.CovarianceReset(every=25),
        rn.CovarianceReset(trace_below=0.2), rn.CovarianceReset(growth=1.2, short=3, long=15),
    ]  # fmt: skip
    reset, small = draw(st.sampled_from(rules)), draw(st.sampled_from([1.0, 1.0, 1e-6, 1e-18]))

    def update(R_theta):
        return rn.UD(
            small * R_theta, reset=reset,
            **({"lambda_": lambda_} if noise is None else {"process_noise": noise}),
        )  # fmt: skip

    low, high = -0.2 - rng.random(size), 0.2 + rng.random(size)
    high[rng.random(size) < 0.3] = np.inf
    box = st.sampled_from(["clip", "metric"]).map(
        lambda m: rn.CoefficientBounds(low, high, method=m)
    )
    l_e = l_y + l_r
    order = draw(st.integers(0, 2))
    beside = rn.Compensator(
        0.2 * rng.standard_normal((order, l_u, l_u)),
        0.1 * rng.standard_normal((order + 1, l_u, l_e)) * draw(st.sampled_from([1.0, 0.0])),
    )
    weights = [None, None, rn.SignalWeight(constant=1, nu=0.3), rn.SignalWeight(0.2, 0.5)]
    more = {
        "update": update,
        "strictly_proper": strictly_proper or form == "filter",
        "form": form,
        "R_u_unfiltered": draw(st.sampled_from([0.0, 0.0, 0.1 * positive(rng, l_u)])),
        "z_normalization": draw(
            st.sampled_from([None, None, rn.Normalization(2.0), rn.Normalization(3.0, 0.5, "root")])
        ),
        "freeze": draw(st.sampled_from([(), ((40, 50),), ((10, 20), (70, None))])),
    }
    for name, weight in (
        ("R_z", draw(st.sampled_from(weights))),
        ("R_u", draw(st.sampled_from(weights))),
    ):
        more |= {} if weight is None else {name: weight}
    settings = draw(settings_for(structure, l_z, **more | fixed))
    theta_0 = settings.theta_0
    L = np.tril(rng.uniform(-0.1, 0.1, (size, size)), -1) + np.diag(0.1 + 0.2 * rng.random(size))
    ellipsoid = st.just(rn.CertifiedBounds(theta_0, L))
    bounds = draw(st.one_of(st.none(), st.none(), box, ellipsoid))
    if isinstance(bounds, rn.CoefficientBounds):
        theta_0 = np.clip(theta_0, *bounds.box(structure))
    changes = {}
    if "target_changes" not in fixed and draw(st.integers(0, 3)) == 0:
        scale = draw(st.floats(0.5, 1.5))
        changes = {
            45: rn.TargetModel(settings.target.numerator * scale, settings.target.denominator)
        }
    settings = replace(
        settings, bounds=bounds, theta_0=theta_0, fixed=draw(st.sampled_from([None, beside])),
        **({"target_changes": changes} if changes else {}),
    )  # fmt: skip
    return settings, draw(engine_plants(l_u, l_y, l_z, l_r))


class Loop:
    """A plant without feedthrough, step by step; w is [r; d]."""

    def __init__(self, plant, l_r, steps, seed):
        self.plant, self.l_r = plant, l_r
        self.w = np.random.default_rng(seed).standard_normal((steps, l_r + 1))
        self.x = np.zeros(plant.n)

    def signals(self, k):
        """(y, z, r); r is None where there is none."""
        w, plant = self.w[k], self.plant
        y = plant.C @ self.x + plant.D_2 @ w
        z = plant.E_1 @ self.x + plant.E_0 @ w
        return y, z, w[: self.l_r] if self.l_r else None

    def move(self, k, u):
        self.x = self.plant.A @ self.x + self.plant.B @ u + self.plant.D_1 @ self.w[k]
