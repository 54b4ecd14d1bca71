"""What decides the last bits of a result beside the study itself."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version


def versions() -> dict[str, str]:
    """Versions by name, as they are installed here."""
    found = {"python": platform.python_version()}
    for name in ("compensator-theory", "numpy", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
