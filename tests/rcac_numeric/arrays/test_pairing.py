"""The least total distance, against all permutations."""

from itertools import permutations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric.arrays._pairing import pairing

points = st.complex_numbers(max_magnitude=2, allow_nan=False)


@given(st.lists(points, min_size=1, max_size=4), st.lists(points, min_size=4, max_size=5))
def test_no_assignment_is_nearer(requested, available):
    requested, available = np.array(requested), np.array(available)
    pairs = pairing(requested, available)
    assert [a for a, _ in pairs] == list(requested)
    left = list(available)
    for _, b in pairs:
        left.remove(b)  # each is used once
    total = sum(abs(a - b) for a, b in pairs)
    best = min(
        sum(abs(a - b) for a, b in zip(requested, chosen, strict=True))
        for chosen in permutations(available, len(requested))
    )
    assert total <= best + 1e-12
