"""Add Python to built pages: the examples' runtime, and the exact lectures in JupyterLite.

``python -m docs.browser docs/_build`` follows ``sphinx-build docs docs/_build``. It needs npm, bash
and git, and what npm and PyPI serve (pins.toml; 50 MB, kept in a cache folder). Where these cannot
be had it says that the pages have no Python, and ends with status 69.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from docs.browser.downloads import UNAVAILABLE, PinsError, UnavailableError
from docs.browser.lite import write_site
from docs.browser.pages import ROOT, exact_lectures


def main() -> int:
    """Write the folder ``lite`` of a built site; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", type=Path, help="the folder of the built pages")
    parser.add_argument("--wheel", type=Path, help="of .ci/exact; without it one is built")
    options = parser.parse_args()
    if not (options.pages / "index.html").exists():
        parser.error(f"{options.pages} has no index.html; sphinx-build docs {options.pages} first")
    try:
        with tempfile.TemporaryDirectory() as folder:
            wheel = options.wheel or exact_wheel(Path(folder))
            size = write_site(options.pages / "lite", wheel, exact_lectures())
    except UnavailableError as error:
        print(f"the pages have no Python for the browser: {error}")
        return UNAVAILABLE
    except PinsError as error:
        print(f"docs/browser/pins.toml: {error}")
        return 1
    print(f"Python for the browser: {options.pages / 'lite'}, {size / 1e6:.0f} MB")
    return 0


def exact_wheel(folder: Path) -> Path:
    """Build the wheel of the exact half.

    Raises
    ------
    UnavailableError
        The wheel is not built, as without bash, git or PyPI.
    """
    try:
        subprocess.run(["bash", ROOT / ".ci" / "exact", "--wheel", folder], check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise UnavailableError(f"the wheel of the exact half is not built: {error}") from error
    return next(folder.glob("*.whl"))


if __name__ == "__main__":
    sys.exit(main())
