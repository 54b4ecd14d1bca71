"""Every function, method and property that the compiled module binds is called, well and badly.

A binding without arguments in tests/support/binding_arguments.py fails here, so none is forgotten.
.ci/sanitize runs this file: nothing may be read or written out of bounds.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rcac_numeric.compiled import _kernel
from tests.support.binding_arguments import FUNCTIONS, MAY_REFUSE, METHODS
from tests.support.kernel_arguments import damaged_state, perhaps_damaged
from tests.support.kernel_calls import attempt, calls

MAKERS = {
    "Arx": ["arx", "mu_markov"],
    "BoxJenkinsErrors": ["box_jenkins_errors"],
    "Controller": ["controller"],
    "EstimationModel": [name for name in FUNCTIONS if name.endswith("_estimation_model")],
    "Filter": ["filter", "interacting_filters", "adaptive_filter"],
    "Job": ["Job"],
    "Loop": ["Loop"],
    "Plant": ["linear_plant", "python_plant"],
    "Refinement": ["refinement"],
}
CLASSES = {n: o for n, o in vars(_kernel).items() if isinstance(o, type) and n in MAKERS}


def public(names):
    return {name for name in names if not name.startswith("_")}


def bound_methods(cls):
    return {name for name in public(vars(cls)) if callable(getattr(cls, name))}


def test_every_binding_has_arguments():
    data = {"lanes", "EstimationError"}  # a number and an exception
    constructors = {name for name, makers in MAKERS.items() if name in makers}
    assert public(vars(_kernel)) - data == (set(FUNCTIONS) - constructors) | set(MAKERS)
    for name, cls in CLASSES.items():
        assert bound_methods(cls) == set(METHODS[name]), name
    assert set(CLASSES) == set(METHODS) == set(MAKERS)


def built(draw, name):
    function = draw(st.sampled_from(MAKERS[name]))
    arguments = FUNCTIONS[function](draw)
    if function == "python_plant":  # its functions may be wrong, and are asked only later
        return getattr(_kernel, function)(**arguments)
    return attempt(getattr(_kernel, function), **arguments)


def use(draw, obj):
    """A few members of an object, in any order; every property where the walk ends."""
    if isinstance(obj, tuple):
        for one in obj:
            use(draw, one)
        return
    if isinstance(obj, np.ndarray | float):
        return
    name = type(obj).__name__
    for _ in range(draw(st.integers(1, 6))):
        if not METHODS.get(name):
            break
        method = draw(st.sampled_from(sorted(METHODS[name])))
        arguments = METHODS[name][method](draw, obj)
        if method == "restore" and draw(st.booleans()):
            arguments = {"state": damaged_state(draw, arguments["state"])}
        attempt(getattr(obj, method), *perhaps_damaged(draw, arguments).values())
    for attribute in public(dir(obj)) - set(METHODS.get(name, ())):
        getattr(obj, attribute)
        calls["read"] += 1


@pytest.mark.parametrize("name", FUNCTIONS)
@settings(max_examples=settings().max_examples // 5)
@given(data=st.data())
def test_functions(name, data):
    function, good = getattr(_kernel, name), FUNCTIONS[name](data.draw)
    if name not in MAY_REFUSE:  # else the rest would show nothing
        use(data.draw, function(**good))
    answer = attempt(function, **perhaps_damaged(data.draw, good))
    if answer is not None:
        use(data.draw, answer)


@pytest.mark.parametrize(("name", "method"), [(n, m) for n in METHODS for m in METHODS[n]])
@settings(max_examples=settings().max_examples // 5)
@given(data=st.data())
def test_methods(name, method, data):
    item = built(data.draw, name)
    before = calls["refused"]
    for _ in range(data.draw(st.integers(1, 3))):
        arguments = METHODS[name][method](data.draw, item)
        answer = attempt(getattr(item, method), *arguments.values())
    assert answer is not None or calls["refused"] == before or may_refuse(name, method)
    use(data.draw, item)


def may_refuse(name, method):
    """What fits may still leave the range of float64, meet a wrong answer or find no room."""
    return (name, method) in {
        ("Controller", "set_target"),
        ("Controller", "set_weights"),
        ("Filter", "move"),
        ("Filter", "run"),
        ("Refinement", "run"),
        ("Plant", "output"),
        ("Plant", "advance"),
        ("Job", "pause_at"),
        ("Loop", "copy"),
    }
