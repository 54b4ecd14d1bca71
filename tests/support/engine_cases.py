"""Random structures with their regressors from the text, and random settings for them."""

import numpy as np
from hypothesis import strategies as st

import rcac_numeric as rn
from rcac_numeric.arrays._values import replaced as replace
from tests.support import textbook as book
from tests.support.strategies import seeds, starts, targets

KINDS = ("iir", "fir", "quasi_fir", "pid", "fir_integrator", "centralised", "fb_fir", "ff", "table")


@st.composite
def structures(draw, l_u, l_y, l_r=0, kinds=KINDS):
    """(structure, regressor): what the package builds, and the text's formula for it."""
    rng = np.random.default_rng(draw(seeds))
    allowed = [kind for kind in kinds if l_r or kind not in ("centralised", "fb_fir", "ff")]
    kind, n_c, k_c = (
        draw(st.sampled_from(allowed)),
        draw(st.integers(1, 3)),
        draw(st.integers(0, 1)),
    )
    sizes = {"l_u": l_u, "l_y": l_y}
    if kind == "iir":
        return rn.iir(n_c, **sizes, k_c=k_c), book.iir_regressor(n_c, k_c)
    if kind == "fir":
        return rn.fir(n_c, **sizes, k_c=k_c), book.iir_regressor(n_c, k_c, lags_of_u=0)
    if kind == "quasi_fir":
        free = draw(st.integers(0, n_c))
        return rn.quasi_fir(n_c, free, **sizes, k_c=k_c), book.iir_regressor(n_c, k_c, free)
    if kind == "pid":
        terms = draw(st.sampled_from(["P", "PI", "PID", "DI", "I", "IDP"]))
        return rn.pid(terms, **sizes), book.pid_regressor(terms)
    if kind == "fir_integrator":
        F = rng.standard_normal((draw(st.integers(1, l_y)), l_y))
        return rn.fir_integrator(n_c, F, **sizes, k_c=k_c), book.integrator_regressor(n_c, F, k_c)
    if kind == "table":
        derived = [
            rn.DerivedSignal(
                rng.standard_normal(l_y + l_r),
                rng.standard_normal(l_y + l_r),
                draw(st.sampled_from([0.0, 0.5, 0.5, -0.9, 1.0])),
            )
            for _ in range(draw(st.integers(0, 3)))
        ]
        widths = {"u": l_u, "y": l_y, "r": l_r, "derived": len(derived)}
        choices = [
            rn.Tap(name, i, lag)
            for name, width in widths.items()
            for i in range(width)
            for lag in range(name == "u", 5)
        ]
        taps = draw(st.lists(st.sampled_from(choices), min_size=1, max_size=5, unique=True))
        structure = rn.Structure(taps, **sizes, l_r=l_r, derived=derived)
        return structure, book.table_regressor(taps, derived)
    first_r = draw(st.integers(0, n_c))
    feedback = {"centralised": "iir", "fb_fir": "fir", "ff": "none"}[kind]
    structure = rn.feedforward(n_c, **sizes, l_r=l_r, k_c=k_c, feedback=feedback, first_r=first_r)
    lags_of_u = 0 if feedback == "fir" else n_c
    k_c = None if feedback == "none" else k_c
    return structure, book.iir_regressor(n_c, k_c, lags_of_u, first_r)


def with_update(settings, **changes):
    """The settings with other settings of the same update."""
    return replace(settings, update=replace(settings.update, **changes))


@st.composite
def cases(draw, l_u, l_y, l_z, l_r=0, kinds=KINDS, **fixed):
    """(settings, regressor) with a random structure, target model, weights and start-up."""
    structure, regressor = draw(structures(l_u, l_y, l_r, kinds))
    return draw(settings_for(structure, l_z, **fixed)), regressor


@st.composite
def settings_for(draw, structure, l_z, strictly_proper=False, update=rn.UD, **fixed):
    """Settings with an update that the function `update` makes of R_theta."""
    rng = np.random.default_rng(draw(seeds))
    target = draw(targets(l_z, structure.l_u))
    if strictly_proper:
        N, D = np.array(target.numerator), np.array(target.denominator)
        target = rn.TargetModel(np.concatenate([0 * N[:1], N]), D)
    k_w = max(structure.n_c, target.n_f) + draw(st.integers(0, 2))
    k_w = max([k_w, *(t.n_f for t in fixed.get("target_changes", {}).values())])
    size = structure.l_theta
    R_theta = draw(st.floats(0.5, 5)) * np.eye(size)
    if draw(st.booleans()):
        root = rng.standard_normal((size, size)) / np.sqrt(size)
        R_theta = R_theta + root @ root.T
    chosen = {
        "update": update((R_theta + R_theta.T) / 2),
        "R_z": np.eye(l_z) + positive(rng, l_z) / 4,
        "R_u": draw(st.sampled_from([0.0, 0.5])) * positive(rng, l_z),
        **draw(starts(k_w)),
        "k_filter": draw(st.sampled_from([0, 0, 1, k_w])),
        "theta_0": 0.1 * rng.standard_normal(size),
    }
    return rn.ControllerSettings(structure=structure, target=target, **chosen | fixed)


def positive(rng, size):
    root = rng.standard_normal((size, size))
    return (root @ root.T + (root @ root.T).T) / 2


@st.composite
def engine_plants(draw, l_u, l_y, l_z, l_r=0, n=None):
    """A stable plant without feedthrough whose w is [r; d]."""
    rng = np.random.default_rng(draw(seeds))
    n = draw(st.integers(1, 3)) if n is None else n
    A = rng.standard_normal((n, n))
    A *= draw(st.floats(0.1, 0.9)) / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    random = lambda rows, columns: rng.standard_normal((rows, columns))  # noqa: E731
    return rn.Plant(
        A=A,
        B=random(n, l_u) / 2,
        D_1=random(n, l_r + 1),
        C=random(l_y, n) / 2,
        D_2=random(l_y, l_r + 1) / 2,
        E_1=random(l_z, n),
        E_0=random(l_z, l_r + 1),
        blocks={"d": 1, "r": l_r} if l_r else {},
    )
