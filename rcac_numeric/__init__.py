"""Retrospective cost adaptive control in float64: run it, and hold it against exact theory.

Every name below is imported when it is first used, so that the command line answers at once.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
del lazy_loader
