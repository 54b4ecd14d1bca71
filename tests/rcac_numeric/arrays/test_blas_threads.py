"""One thread of BLAS inside, and as many as before afterwards, nested and from several threads."""

from threading import Event, Thread

import numpy as np
import pytest
import scipy.linalg  # noqa: F401  its BLAS is another library than NumPy's
from threadpoolctl import threadpool_info, threadpool_limits

from rcac_numeric.arrays._blas_threads import one_blas_thread


def threads():
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


@pytest.fixture(autouse=True)
def two_threads():
    with threadpool_limits(2, user_api="blas"):
        yield


def test_the_outermost_use_counts():
    before = threads()
    with one_blas_thread():
        with one_blas_thread():
            assert threads() == [1] * len(before)
        assert threads() == [1] * len(before)
    assert threads() == before


def test_the_number_returns_after_an_error():
    before = threads()
    with pytest.raises(np.linalg.LinAlgError), one_blas_thread():
        np.linalg.solve(np.zeros((2, 2)), np.ones(2))
    assert threads() == before


def test_another_thread_changes_nothing():
    before, is_inside, may_leave = threads(), Event(), Event()

    def other():
        with one_blas_thread():
            is_inside.set()
            may_leave.wait(10)

    thread = Thread(target=other)
    with one_blas_thread():
        thread.start()
        assert is_inside.wait(10) and threads() == [1] * len(before)
    assert threads() == before
    may_leave.set()
    thread.join(10)
    assert threads() == before
