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
