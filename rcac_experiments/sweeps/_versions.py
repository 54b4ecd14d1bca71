"""Versions and settings that decide the last bits of a result."""

from __future__ import annotations

import functools
import importlib
import os
import platform
import re
import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import scipy.linalg  # with it comes its BLAS

from rcac_numeric.arrays._wording import shortened

LIBRARIES = ("compensator-theory", "numpy", "scipy", "sympy", "python-flint")
# Said of the machine; what it decides are the instructions, and those are compared by themselves.
NOT_COMPARED = ("platform", "processor")

# The folders in which the wheels of NumPy and SciPy, or the two themselves, keep a BLAS.
_BUNDLED_BLAS = re.compile(r"[/\\](numpy|scipy)(\.libs)?[/\\]")


@functools.cache
def _versions() -> tuple[tuple[str, str], ...]:
    versions = {"python": f"{platform.python_implementation()} {platform.python_version()}"}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "not installed"
    if commit := _commit(Path(__file__).resolve().parents[2]):
        versions["commit"] = commit
    versions["numpy's BLAS"] = _blas(np.show_config)
    versions["scipy's BLAS"] = _blas(scipy.show_config)
    if kernels := _blas_kernels():
        versions["BLAS kernels"] = kernels
    versions["platform"] = f"{platform.system()} {platform.release()} {platform.machine()}"
    versions["processor"] = _processor()
    return tuple((name, shortened(words, 200)) for name, words in versions.items())


def versions() -> dict[str, str]:
    """Versions by name, as they are installed here; of a checkout its commit too."""
    return dict(_versions())


def differing(then: dict[str, str], now: dict[str, str]) -> dict[str, tuple[str, str]]:
    """Return changed versions that can change a digit, by name."""
    return {
        name: (words, now.get(name, "absent"))
        for name, words in then.items()
        if name not in NOT_COMPARED and now.get(name) != words
    }


def _commit(root: Path) -> str:
    """The commit of a checkout, and whether something in it was changed since."""
    git = shutil.which("git")
    if git is None or not (root / ".git").exists():
        return ""
    try:
        out = subprocess.run(
            [git, "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40",
             "--exclude=*"],
            capture_output=True, text=True, timeout=10, check=True,
            env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return ""
    return out.stdout.strip()


def _blas(show: Any) -> str:
    """Return the build options of a library."""
    try:
        blas = show(mode="dicts")["Build Dependencies"]["blas"]
    except (KeyError, TypeError):
        return "unknown"
    parts = (str(blas.get(key, "")) for key in ("name", "version", "openblas configuration"))
    return " ".join(" ".join(parts).split())


def _blas_kernels() -> str:
    """The kernels that BLAS chose for this processor, if threadpoolctl knows them."""
    try:
        threadpool_info = importlib.import_module("threadpoolctl").threadpool_info
    except ImportError:
        return os.environ.get("OPENBLAS_CORETYPE", "")
    kernels = {
        f"{one.get('internal_api')} {one.get('version')} {one.get('architecture', '')}".strip()
        for one in threadpool_info()
        # What else is loaded, a library with a BLAS of its own for instance, decides no digit here.
        if one.get("user_api") == "blas" and _BUNDLED_BLAS.search(str(one.get("filepath")))
    }
    return ", ".join(sorted(kernels))


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(errors="replace").splitlines()
    except OSError:
        return platform.processor()
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor())
