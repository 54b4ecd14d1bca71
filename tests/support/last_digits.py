"""Data moved in the last digit, as another BLAS, CPU or SciPy moves what is computed from them.

`--perturb SEED` moves every float64 that the numeric half reads as an array or a number, and every
matrix that NumPy's and SciPy's linear algebra is handed: a backward stable algorithm on another
machine solves such a neighbouring problem, too. A bound that follows from the conditioning of its
test survives that.

The last bit of an entry becomes a hash of the others and of the seed. So equal entries stay equal,
a matrix stays symmetric, and what was moved once is not moved again when it is copied or saved and
read. Integers, among them zeros and ones, say what a thing is and stay.
"""

import functools

import numpy as np

# In numpy.linalg and scipy.linalg: what factors, solves or searches.
FACTORED = (
    *("cholesky", "eig", "eigh", "eigvals", "eigvalsh", "qr", "schur", "svd", "svdvals"),
    *("cond", "det", "inv", "lstsq", "matrix_rank", "pinv", "slogdet", "solve", "solve_sylvester"),
    *("solve_continuous_are", "solve_continuous_lyapunov"),
    *("solve_discrete_are", "solve_discrete_lyapunov"),
)
INTEGERS_FROM = 2.0**52  # every float64 is one from here on


class LastDigits:
    """The last digits of one seed; `active` is switched off for a test of exact data."""

    def __init__(self, seed):
        self.seed = np.uint64(seed)
        self.active = True

    def moved(self, array):
        """An array of float64 or complex128 with its last digits moved; anything else as it is."""
        if not self.active or not isinstance(array, np.ndarray) or array.dtype.kind not in "fc":
            return array
        if array.dtype not in (np.dtype(np.float64), np.dtype(np.complex128)):
            return array
        values = np.array(array, order="C")  # a copy
        flat = values.reshape(-1).view(np.float64)
        bits = flat.view(np.uint64)
        with np.errstate(invalid="ignore"):
            moves = (np.abs(flat) < INTEGERS_FROM) & (flat != np.rint(flat))
        bits[moves] = (bits[moves] & ~np.uint64(1)) | self._bit(bits[moves])
        return values

    def _bit(self, bits):
        """The upper bit of a hash of all but the sign and the last bit."""
        with np.errstate(over="ignore"):
            x = ((bits << np.uint64(1)) >> np.uint64(2)) + self.seed * np.uint64(0x9E3779B97F4A7C15)
            x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return (x ^ (x >> np.uint64(31))) >> np.uint64(63)

    def install(self):
        """Move what the numeric half reads, and what linear algebra is handed, from now on."""
        import scipy.linalg

        from rcac_numeric.arrays import _validation as validation

        validation.float_array = self._moving_result(validation.float_array)
        for module in (np.linalg, scipy.linalg):
            for name in FACTORED:
                if hasattr(module, name):
                    setattr(module, name, self._moving_arguments(getattr(module, name)))
        np.roots = self._moving_arguments(np.roots)

    def _moving_result(self, function):
        @functools.wraps(function)
        def moving(*arguments, **options):
            return self.moved(function(*arguments, **options))

        return moving

    def _moving_arguments(self, function):
        @functools.wraps(function)
        def moving(*arguments, **options):
            return function(*(self.moved(value) for value in arguments), **options)

        return moving
