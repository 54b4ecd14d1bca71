"""Pictures of several runs, of stability regions, and of what a figure of a file asks for."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
