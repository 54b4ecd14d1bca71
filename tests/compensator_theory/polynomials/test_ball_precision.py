"""The one precision of python-flint: restored, waited for, and never relied on where it moved."""

import subprocess
import sys
import threading

import flint
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory.errors import PrecisionError
from compensator_theory.polynomials._algebraic import algebraic
from compensator_theory.strategies import polynomials


@pytest.fixture
def outside():
    """Sets the precision as a program might that uses python-flint itself."""
    before = flint.ctx.prec
    yield lambda bits: setattr(flint.ctx, "prec", bits)
    flint.ctx.prec = before


def answers(poly):
    result = [repr(exact.certified_roots(poly)), repr(exact.count_roots(poly))]
    in_s = poly.replace(poly.gen, sympy.Symbol("s"))
    for ask in (
        exact.roots.enclose_split_at_unit_circle,
        exact.spectral_factor,
        lambda _: exact.spectral_factor(in_s, in_s + 1),
    ):
        try:
            result.append(repr(ask(poly)))
        except exact.CompensatorError as error:
            result.append(str(error))
    root = exact.exact_number("sqrt(2 + sqrt(3)) - sqrt(5)/7")
    return [*result, exact.canonical(root), algebraic(root).minimal]


@pytest.mark.costly
@given(poly=polynomials(variable="q", max_degree=5), bits=st.sampled_from([2, 12, 500, 4000]))
def test_the_precision_outside_changes_nothing(poly, bits):
    if poly.is_zero:
        return
    before, usual = flint.ctx.prec, answers(poly)
    flint.ctx.prec = bits
    try:
        assert answers(poly) == usual
        assert flint.ctx.prec == bits
    finally:
        flint.ctx.prec = before


def test_it_is_restored_whatever_happens_inside():
    before = flint.ctx.prec
    with pytest.raises(KeyError), exact.ball_precision(300):
        with exact.ball_precision(80):
            assert flint.ctx.prec == 80
        assert flint.ctx.prec == 300
        raise KeyError
    assert flint.ctx.prec == before


@pytest.mark.parametrize("bits", [True, 1, -5, 2.0, "53", None])
def test_what_is_no_precision_is_refused(bits):
    with pytest.raises(exact.InputError, match="integer of at least 2"), exact.ball_precision(bits):
        raise AssertionError("nothing may be computed")


@pytest.mark.parametrize("error", [None, ZeroDivisionError])
def test_what_was_computed_while_it_moved_is_not_relied_on(error, outside):
    before = flint.ctx.prec
    with (
        pytest.raises(PrecisionError, match=r"300 bits.*77"),
        exact.ball_precision(300),
    ):
        thread = threading.Thread(target=outside, args=(77,))
        thread.start()
        thread.join()
        if error:
            raise error
    assert flint.ctx.prec == before


def test_another_thread_waits_for_its_turn():
    observed, inside = [], threading.Event()

    def other():
        inside.set()
        with exact.ball_precision(64):
            observed.append(flint.ctx.prec)

    thread = threading.Thread(target=other)
    with exact.ball_precision(200):
        thread.start()
        inside.wait()
        for _ in range(200):
            assert flint.ctx.prec == 200 and not observed
            flint.acb_mat([[1, 2], [3, 4]]).det()
    thread.join()
    assert observed == [64]


FORKS = """
import os, threading, flint
from compensator_theory import ball_precision
inside, over = threading.Event(), threading.Event()
def other():
    with ball_precision(999):
        inside.set()
        over.wait()
thread = threading.Thread(target=other)
thread.start()
inside.wait()
child = os.fork()
if child == 0:
    assert flint.ctx.prec == 53  # the thread that set it does not go on here
    with ball_precision(100):
        os._exit(7 if flint.ctx.prec == 100 else 1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
over.set()
thread.join()
assert flint.ctx.prec == 53
with ball_precision(64):
    child = os.fork()
    if child == 0:
        assert flint.ctx.prec == 64
        os._exit(8)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 8
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there is no fork")
def test_a_forked_child_does_not_wait_for_a_thread_that_it_has_not():
    out = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", FORKS], capture_output=True, text=True, check=False
    )
    assert out.returncode == 0, out.stderr
