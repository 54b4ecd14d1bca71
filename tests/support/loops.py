"""Random scalar loop transfer functions, most of them stable once they are closed."""

import control
import numpy as np
from hypothesis import strategies as st

seeds = st.integers(0, 2**32 - 1)


def random_loop(seed):
    """L = N / D of order 1 to 6, open-loop stable or not, strictly or exactly proper."""
    rng = np.random.default_rng(seed)
    order = int(rng.integers(1, 7))
    pairs, rest = divmod(order, 2)
    poles = _conjugate(rng, pairs, rest, 1.3)
    zero_pairs = int(rng.integers(0, pairs + 1))
    zeros = _conjugate(rng, zero_pairs, int(rng.integers(0, rest + 1)), 1.5)
    gain = rng.standard_normal()
    if rng.random() < 0.6:  # a closed loop that is stable, and the zeros wanted
        closed = np.poly(_conjugate(rng, pairs, rest, 0.98)).real
        L_numerator = closed - np.poly(poles).real
        if np.any(L_numerator):
            return control.tf(L_numerator, np.poly(poles).real, True)
    return control.tf(gain * np.atleast_1d(np.poly(zeros)).real, np.poly(poles).real, True)


def _conjugate(rng, pairs, real, largest):
    upper = rng.uniform(0, largest, pairs) * np.exp(1j * rng.uniform(0, np.pi, pairs))
    single = rng.uniform(-largest, largest, real)
    return np.concatenate([upper, upper.conj(), single])
