"""Arguments of the compiled module, as they should be and with something in them that is not."""

import numpy as np
from hypothesis import strategies as st

# Around zero, around the sizes that are in use, and around the ends of the integers.
SMALL = (-1, 0, 1, 2, 3, 4, 7, 63, 64, 65, 300)
LARGE = (2**31, 2**32 + 1, 2**40, 2**61, 2**62, 2**62 + 1, 2**63 - 1, 2**63, 2**64 - 1, 2**64)
integers = st.sampled_from([*SMALL, *LARGE, -(2**31), -(2**62), -(2**63)])
floats = st.sampled_from(
    [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        3.0,
        np.nan,
        np.inf,
        -np.inf,
        1e308,
        -1e308,
        5e-324,
        1e-200,
        2.0**64,
    ]
)
strangers = st.sampled_from([None, "", "ud", "no such name", b"", (), [], {}, object(), 1j, True])
seeds = st.integers(0, 2**32 - 1)
# Taken modulo a length, which may depend on how far a run has come in its time.
places = st.integers(0, 10**6)


@st.composite
def arrays(draw, like=None):
    """An array that is nearly `like`: of another size, shape, type, order or content."""
    base = np.array([0.5, -0.5] if like is None else np.real(like), dtype=float)
    kind = draw(st.integers(0, 11))
    if kind == 0:
        return np.zeros(draw(st.integers(0, 40)))
    if kind == 1:
        return np.full(base.shape, draw(floats))
    if kind == 2:
        return np.append(base.ravel(), 1.0)
    if kind == 3:
        return base.ravel()[:-1]
    if kind == 4:
        return base.ravel()
    if kind == 5:
        return np.array(draw(floats))
    if kind == 6 and base.size:
        return np.zeros((2, *base.shape))[1]
    if kind == 7:
        return np.repeat(base.ravel(), 2)[::2]
    if kind == 8:
        with np.errstate(all="ignore"):
            return base.astype(draw(st.sampled_from([int, np.float32, complex, bool])))
    if kind == 9:
        base.flags.writeable = False
        return base
    if kind == 10:
        return np.zeros((draw(st.sampled_from([3, 2**33, 2**50])), 0))
    changed = base.ravel().copy()
    place, number = draw(places), draw(floats)
    if changed.size:
        changed[place % changed.size] = number
    return changed.reshape(base.shape)


def damaged(draw, value):
    """`value` with one thing in it, at any depth, that may not belong there."""
    if draw(st.integers(0, 12)) == 0:
        return draw(strangers)
    if isinstance(value, np.ndarray):
        return draw(arrays(value))
    if isinstance(value, list | tuple) and len(value) > 0:
        items, i = list(value), draw(st.integers(0, len(value) - 1))
        deed = draw(st.integers(0, 6))
        if deed == 0:
            del items[i]
        elif deed == 1:
            items.insert(i, items[i])
        else:
            items[i] = damaged(draw, items[i])
        return type(value)(items)
    if isinstance(value, bool | str) or value is None or callable(value):
        return draw(st.one_of(strangers, integers))
    if isinstance(value, int):
        return draw(integers)
    return draw(st.one_of(floats, integers))


def perhaps_damaged(draw, arguments):
    """Keyword arguments of which up to three do not belong; mostly none or one."""
    for _ in range(draw(st.sampled_from([0, 0, 1, 1, 2, 3])) if arguments else 0):
        name = draw(st.sampled_from(sorted(arguments)))
        arguments = {**arguments, name: damaged(draw, arguments[name])}
    return arguments


SIZES = st.tuples(*[st.integers(1, 2)] * 4, st.integers(0, 2))  # l_u, l_y, l_z, n, l_w


def controller_arguments(draw, l_u, l_y, l_z, l_r):
    """Arguments of a controller that is as it should be."""
    rng = np.random.default_rng(draw(seeds))
    limit = draw(st.sampled_from([np.inf, 0.4]))
    derived = [(rng.standard_normal(l_y + l_r), rng.standard_normal(l_y + l_r), 0.5, limit)]
    derived = derived[: draw(st.integers(0, 1))]
    signals = l_u + l_y + l_r + len(derived)
    taps = [(int(rng.integers(0, signals)), int(rng.integers(1, 5))) for _ in range(4)]
    taps = taps[: draw(st.integers(1, 4))]
    channels = [*((i, 0) for i in range(l_u)), *taps]
    order, l_theta = draw(st.integers(0, 3)), len(taps) * l_u
    models = []
    for _ in range(draw(st.integers(1, 2))):
        denominator = 0.2 * rng.standard_normal((order + 1, l_z, l_z)) * draw(st.integers(0, 1))
        denominator[0] = np.eye(l_z)
        models.append((rng.standard_normal((order + 1, l_z, l_u)), denominator))
    kinds = [(3, "freeze", 0.0), (5, "resume", 0.0), (6, "reset", 0.0), (7, "forgetting", 0.9)]
    events = [*kinds, (8, "target", float(len(models) - 1))]
    weights = [
        np.eye(l_z),
        (np.eye(l_z), 0.1, 0.0),
        (np.eye(l_z), 0.0, 0.3),
        lambda k, y, z, u: np.eye(l_z) * (1 + min(abs(z[0]), 9.0)),
    ]
    return {
        "l_u": l_u,
        "l_y": l_y,
        "l_r": l_r,
        "l_z": l_z,
        "derived": derived,
        "regressor": taps,
        "channels": channels,
        "filtered": [(l_u + j, draw(st.integers(0, 2))) for j in range(len(taps))],
        "targets": models,
        "R_z": draw(st.sampled_from(weights)),
        "R_u": draw(st.sampled_from([0.0 * np.eye(l_z), (0.0 * np.eye(l_z), 0.1, 0.2)])),
        "forgetting_factor": draw(st.sampled_from([1.0, 0.99])),
        "k_w": draw(st.integers(0, 5)),
        "k_update": draw(st.integers(0, 5)),
        "k_filter": draw(st.integers(0, 2)),
        "filter_form": draw(st.booleans()),
        "reflect_poles": draw(st.booleans()) and l_u == 1,
        "events": events if draw(st.booleans()) else [],
        "forgetting": draw(st.sampled_from([(0, 0, 0.0, 1.0), (2, 6, 0.5, 0.9)])),
        "reset": draw(st.sampled_from([(0, 0.0, 0.0, 1, 2), (4, 0.1, 2.0, 2, 5)])),
        "noise": rng.standard_normal(l_theta * draw(st.integers(0, 2))),
        "update": draw(
            st.sampled_from(
                ["ud", "ud", "covariance", "sliding window", "instantaneous", "gradient"]
            )
        ),
        "P_0": np.eye(l_theta),
        "theta_0": 0.1 * rng.standard_normal(l_theta),
        "window": draw(st.integers(1, 5)),
        "step_size": 0.01,
        **additions(draw, l_u, l_y + l_r, l_theta),
    }


def additions(draw, l_u, l_e, l_theta):
    """What a controller may have beside the text's."""
    every = {
        "dither": (3, 0.1, 0.01, 2),
        "penalty": 0.1 * np.eye(l_u),
        "normalization": (draw(st.integers(1, 5)), 2.0, 1.0),
        "bounds": (-np.ones(l_theta), np.ones(l_theta), draw(st.booleans()), 9),
        "ellipsoid": (
            np.zeros(l_theta),
            0.1 * np.tri(l_theta),
            draw(st.booleans()),
            1 - 1e-12,
            1 - 2e-12,
        ),
        "fixed": (np.full((1, l_u, l_u), 0.1), np.full((2, l_u, l_e), 0.2)),
    }
    chosen = draw(st.sets(st.sampled_from(sorted(every))))
    if "bounds" in chosen:  # a box or an ellipsoid
        chosen = chosen - {"ellipsoid"}
    return {name: every[name] for name in sorted(chosen)}


def segment(rng, n, l_u, l_w, l_y, l_z):
    rows, columns = (n, l_y, l_z), (n, l_u, l_w)
    matrices = [0.3 * rng.standard_normal((r, c)) for r in rows for c in columns]
    matrices[4], matrices[7] = 0.0 * matrices[4], 0.0 * matrices[7]
    return matrices


def plant_arguments(draw, l_u, l_y, l_z, n, l_w):
    """Arguments of a linear plant that is as it should be: up to three segments."""
    rng = np.random.default_rng(draw(seeds))
    segments, before = [], n
    for i in range(draw(st.integers(1, 3))):
        after = draw(st.integers(0, 3)) if i else n
        jump = rng.standard_normal((after, before)) if after != before else np.zeros(0)
        if jump.size == 0 and after != before:
            after = before
        matrices = segment(rng, after, l_u, l_w, l_y, l_z)
        segments.append((4 * i, matrices, False, jump, draw(st.integers(0, 2))))
        before = after
    return {"sizes": (n, l_u, l_w, l_y, l_z), "segments": segments, "x_0": np.zeros(n)}


def python_plant_arguments(draw, l_u, l_y, l_z, n, l_w):
    """Functions that may answer with anything, or raise."""
    bad = draw(st.sampled_from([None, None, "advance", "output"]))
    answer = damaged(draw, (np.zeros(l_y), np.zeros(l_z)) if bad == "output" else np.zeros(n))
    when = draw(st.integers(0, 6))

    def advance(k, x, u, w):
        return answer if bad == "advance" and k >= when else 0.5 * x

    def output(k, x, w):
        if bad == "output" and k >= when:
            return answer
        return np.full(l_y, 0.1), np.full(l_z, 0.2)

    sizes = (n, l_u, l_w, l_y, l_z)
    return {"sizes": sizes, "advance": advance, "output": output, "x_0": np.zeros(n)}


def damaged_state(draw, state):
    """A saved state cut, prolonged, or with numbers of another run, or of none, in it."""
    values = np.array(state)
    deed = draw(st.integers(0, 5))
    if deed == 0:
        return values[: draw(places) % (values.size + 1)]
    if deed == 1:
        return np.append(values, draw(floats))
    if deed == 2:
        return draw(arrays(values))
    for _ in range(draw(st.integers(1, 4))):
        place = draw(places) % values.size
        number = draw(integers)
        if draw(st.booleans()) and -(2**63) <= number < 2**63:
            values.view(np.int64)[place] = number
        else:
            values[place] = draw(floats)
    return values
