"""Plants that the literature names: benchmarks, aircraft, converters, loops with tiny margins."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("rcac_numeric", __file__)
