"""On-line estimation of states, parameters and subsystems (Chapter 8); nothing here smooths."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
