"""Optional libraries: how to install them, and a defect of one of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import ContextDecorator, contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from compensator_theory.errors import InputError

EXTRAS = {
    "distributed": "dask",
    "h5py": "logs",
    "hypothesis": "proofs",
    "matplotlib": "plot",
    "openpyxl": "logs",
    "pandas": "pandas",
    "pyarrow": "studies",
    "pyulog": "logs",
    "xarray": "pandas",
}
"""Each optional library, and the extra of this package that installs it."""


@contextmanager
def needed(library: str, extra: str = "") -> Iterator[None]:
    """Turn a missing optional library into an error that names the extra to install.

    Parameters
    ----------
    library : str
    extra : str
        That of the task, where several extras install the library; by default that of `EXTRAS`.

    Examples
    --------
    >>> from compensator_theory.libraries import needed
    >>> with needed("pandas"):
    ...     raise ModuleNotFoundError("as if it were missing", name="pandas")
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: pandas is not installed, and this needs it: `pip install
    'compensator-theory[pandas]'` brings it.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != library:
            raise  # the library is installed, but one of its dependencies is missing
        raise InputError(_missing(library, extra)) from None


def require_library(library: str) -> None:
    """Refuse a request whose optional library is not installed, before any long computation.

    Raises
    ------
    InputError

    Examples
    --------
    >>> from compensator_theory.libraries import require_library
    >>> require_library("sympy")
    """
    if find_spec(library) is None:
        raise InputError(_missing(library))


ELSEWHERE = {
    "acker": "regulator_gain(A, B, poles), for A + B K",
    "allmargin": "stability_margins(G, feedback=-1)",
    "bode": "G.plot('bode')",
    "bode_plot": "G.plot('bode')",
    "c2d": "sampling.zero_order_hold(G, h)",
    "care": "solve_riccati(A, B, Q, R, time='continuous')",
    "ctrb": "controllability_matrix(A, B)",
    "d2c": "sampling.inverse_zero_order_hold(G, h)",
    "damp": "G.poles()",
    "dare": "solve_riccati(A, B, Q, R, time='discrete')",
    "dcgain": "G(0), in discrete time G(1)",
    "dlyap": "solve_stein(A, Q)",
    "evalfr": "G('2j')",
    "expm": "transition_matrix(A)",
    "feedback": "feedback_connection(G, K, feedback=-1)",
    "forced_response": "time_response(G, '1/s**2')",
    "gram": "gramians(G)",
    "hinfnorm": "h_infinity_norm(G)",
    "impulse": "impulse_response(G)",
    "initial_response": "transition_matrix(A)",
    "is_stable": "decide_stability(G)",
    "isstable": "decide_stability(G)",
    "jury": "jury_array(p)",
    "lqr": "solve_riccati(A, B, Q, R, time='continuous').K, for A + B K",
    "lsim": "time_response(G, '1/s**2')",
    "lyap": "solve_lyapunov(A, Q)",
    "margin": "stability_margins(G, feedback=-1)",
    "minreal": "G.reduced(), of a realisation minimal_realisation(G)",
    "nyquist": "G.plot('nyquist')",
    "nyquist_plot": "G.plot('nyquist')",
    "obsv": "controllability_matrix of the transposes",
    "pade": "transfer_function('exp(-s)').pade(2)",
    "place": "regulator_gain(A, B, poles), for A + B K",
    "pole": "G.poles()",
    "poles": "G.poles()",
    "pole_zero_plot": "G.plot('poles')",
    "pzmap": "G.plot('poles')",
    "residue": "partial_fractions(G)",
    "rlocus": "root_locus(G, feedback=-1)",
    "routh": "routh_array(p)",
    "sample_system": "sampling.zero_order_hold(G, h)",
    "ss": "realisation((A, B, C, D), 's')",
    "ss2tf": "realisation((A, B, C, D), 's').transfer_function()",
    "stability_margin": "stability_margins(G, feedback=-1)",
    "step": "step_response(G)",
    "step_info": "step_response(G).overshoot(), .settling_time() and .rise_time()",
    "stepinfo": "step_response(G).overshoot(), .settling_time() and .rise_time()",
    "tf": "transfer_function('1/(s + 1)') or transfer_function(([1], [1, 1]), 's')",
    "tf2ss": "realisation(G)",
    "tzero": "transmission_zeros(G)",
    "zero": "G.zeros()",
    "zeros": "G.zeros()",
    "zpk": "transfer_function(zeros=[], poles=[-1], gain=1, variable='s')",
}
"""Names of MATLAB, python-control and SymPy, and what is typed here for the same."""


def absent_attribute(owner: object, name: str) -> AttributeError:
    """Return the AttributeError of a system; it translates a name of another program.

    Examples
    --------
    >>> import compensator_theory
    >>> compensator_theory.transfer_function("1/(s + 1)").dcgain()
    Traceback (most recent call last):
        ...
    AttributeError: 'TransferFunction' object has no attribute 'dcgain'; write G(0), in discrete
    time G(1)
    """
    typed = ELSEWHERE.get(name)
    if typed is None and name in _FUNCTIONS_OF_SYSTEMS:
        typed = _FUNCTIONS_OF_SYSTEMS[name]
    hint = "" if typed is None else f"; write {typed}"
    return AttributeError(f"{type(owner).__name__!r} object has no attribute {name!r}{hint}")


_FUNCTIONS_OF_SYSTEMS = {
    "den": "G.denominator",
    "feedback_with": "feedback_connection(G, K, feedback=-1)",
    "impulse_response": "impulse_response(G)",
    "num": "G.numerator",
    "root_locus": "root_locus(G, feedback=-1)",
    "sample": "sampling.zero_order_hold(G, h)",
    "stability_margins": "stability_margins(G, feedback=-1)",
    "step_response": "step_response(G)",
    "time_response": "time_response(G, '1/s**2')",
}
"""Functions here that other programs have as methods of a system."""


def absent(name: str, *packages: ModuleType) -> AttributeError:
    """Return the AttributeError of a missing name, with the namespace that has it.

    Examples
    --------
    >>> import compensator_theory
    >>> from compensator_theory.libraries import absent
    >>> print(absent("tustin", compensator_theory))
    module 'compensator_theory' has no attribute 'tustin'; it is compensator_theory.sampling.tustin
    """
    package = None if name.startswith("_") else next(_places(name, packages), None)
    hint = "" if package is None else f"; it is {package}.{name}"
    if package is None and name in ELSEWHERE:
        hint = f"; write {ELSEWHERE[name]}"
    return AttributeError(f"module {packages[0].__name__!r} has no attribute {name!r}{hint}")


def _places(name: str, packages: Iterable[ModuleType]) -> Iterator[str]:
    """Return the public namespaces that have a name."""
    line = re.compile(rf"(?: as |^class ){re.escape(name)}\b", re.MULTILINE)
    for package in packages:
        folder = Path(str(package.__file__)).parent
        lists = ("__init__.pyi", "[a-z]*.pyi", "*/__init__.py*", "errors.py")
        for file in (one for pattern in lists for one in sorted(folder.glob(pattern))):
            if line.search(file.read_text(encoding="utf-8")):
                inner = file.relative_to(folder).with_suffix("").parts
                yield ".".join((package.__name__, *(p for p in inner if p != "__init__")))


def _missing(library: str, extra: str = "") -> str:
    extra = extra or EXTRAS[library]
    return (
        f"{library} is not installed, and this needs it: `pip install "
        f"'compensator-theory[{extra}]'` brings it."
    )


class roots_in_sympy(ContextDecorator):
    """Turn a silent failure of SymPy 1.14 on roots of long integers into an error.

    Its factorint takes a product of two close numbers apart and then insists that they are prime.

    Examples
    --------
    >>> import sympy
    >>> from compensator_theory.libraries import roots_in_sympy
    >>> with roots_in_sympy():
    ...     sympy.sqrt((10**18 + 7) * (10**18 + 9))
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: SymPy cannot factor an integer under a root, a product of
    two close ones of 19 digits or so; give rational numbers close to the roots
    """

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if not isinstance(error, ValueError):
            return
        fault = re.fullmatch(r"(\d+) is not a prime factor of \d+", str(error))
        if fault is not None:
            raise InputError(
                "SymPy cannot factor an integer under a root, a product of two close ones of "
                f"{len(fault[1])} digits or so; give rational numbers close to the roots"
            ) from None
