"""Libraries: what installs those that only some doors need, and what one of them cannot do."""

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
    "hypothesis": "proofs",
    "matplotlib": "plot",
    "pandas": "pandas",
    "pyarrow": "studies",
    "xarray": "pandas",
}
"""Each library that is not always there, and the extra of ours that brings it."""


@contextmanager
def needed(library: str) -> Iterator[None]:
    """Around an import of a library that may be missing.

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
            raise  # it is there, and lacks something itself
        raise InputError(_missing(library)) from None


def require_library(library: str) -> None:
    """Refuse, before anything long is run, what will need a library that is not installed.

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
    """The error of the first package for a name that it has not: where it is, if it is anywhere.

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
    """The packages and their public namespaces that have a name, by their lists of names."""
    line = re.compile(rf"(?: as |^class ){re.escape(name)}\b", re.MULTILINE)
    for package in packages:
        folder = Path(str(package.__file__)).parent
        lists = ("__init__.pyi", "[a-z]*.pyi", "*/__init__.py*", "errors.py")
        for file in (one for pattern in lists for one in sorted(folder.glob(pattern))):
            if line.search(file.read_text(encoding="utf-8")):
                inner = file.relative_to(folder).with_suffix("").parts
                yield ".".join((package.__name__, *(p for p in inner if p != "__init__")))


def _missing(library: str) -> str:
    extra = EXTRAS[library]
    return (
        f"{library} is not installed, and this needs it: `pip install "
        f"'compensator-theory[{extra}]'` brings it."
    )


class roots_in_sympy(ContextDecorator):
    """Around what multiplies roots of long integers: SymPy 1.14 fails on some, and says nothing.

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
