"""Exact compensator theory: the closed-loop poles that a dynamic compensator can place.

Integers, rationals and symbols; never a float, never a tolerance. Loops of chapters 2 and 4
(:class:`StandardProblem`, the intercalated transfer function) use positive feedback, ``u = G_c y``;
:func:`place_poles` asks for the sign. ``__version__`` is that of the installed distribution, and
``0+not.installed`` in a checkout that is not.
"""

from __future__ import annotations

import lazy_loader

_public, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
del lazy_loader


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name != "__version__":
        try:
            return _public(name)
        except AttributeError:
            if name in __all__:
                raise
        import sys

        from compensator_theory.libraries import absent

        raise absent(name, sys.modules[__name__])
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("compensator-theory")
    except PackageNotFoundError:
        return "0+not.installed"
