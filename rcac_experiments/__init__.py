"""Users of the two libraries: experiment files, judging, studies, pages, the dissertation, `rcac`.

Every name below is imported when it is first used, so that the command line answers at once.
"""

import lazy_loader

import compensator_theory as _exact

_public, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
del lazy_loader


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name == "__version__":
        return _exact.__version__
    try:
        return _public(name)
    except AttributeError:
        if name in __all__:
            raise
    import sys

    import rcac_numeric
    from compensator_theory.libraries import absent

    raise absent(name, sys.modules[__name__], rcac_numeric, _exact)
