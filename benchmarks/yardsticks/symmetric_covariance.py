"""The covariance recursion on one triangle of P, compiled where it is needed."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).with_suffix(".cpp")


def compiler():
    """The C++ compiler of this machine, or None."""
    return shutil.which(os.environ.get("CXX", "c++"))


@cache
def library():
    """The yardstick, compiled for this processor; its file is gone once it is loaded."""
    if compiler() is None:
        raise SystemExit("the yardstick is compiled by the benchmark: install a C++ compiler")
    with tempfile.TemporaryDirectory() as folder:
        binary = Path(folder) / "yardstick.so"
        options = ["-std=c++17", "-O3", "-march=native", "-ffp-contract=fast", "-shared", "-fPIC"]
        subprocess.run([compiler(), *options, "-Wno-psabi", SOURCE, "-o", binary], check=True)
        function = ctypes.CDLL(str(binary)).symmetric_covariance
    array = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    function.argtypes = [*[ctypes.c_size_t] * 3, array, array, ctypes.c_double, array, array]
    function.restype = None
    return function


def replay(Phi_f, target, *, forgetting=1.0, P_0, theta_0, repeat=1):
    """Theta and P after the measurements  Phi_f[k] theta + target[k] = 0  of unit weight.

    Shapes: Phi_f (steps, l_theta), target (steps,), P_0 (l_theta, l_theta), theta_0 (l_theta,).
    """
    steps, l_theta = Phi_f.shape
    assert target.shape == (steps,) and theta_0.shape == (l_theta,)
    theta, P = np.array(theta_0), np.array(P_0)
    assert P.shape == (l_theta, l_theta)
    rows, values = np.ascontiguousarray(Phi_f), np.ascontiguousarray(target)
    library()(l_theta, steps, repeat, rows, values, forgetting, P, theta)
    return theta, P
