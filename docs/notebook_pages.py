"""What pages with code cells need: the lectures among them, and how their kernel draws."""

from pathlib import Path

from docs.reference_pages import ROOT, changed

SETTINGS = """c.InteractiveShellApp.matplotlib = "inline"
c.InlineBackend.figure_formats = {"retina"}
"""


def copy_notebooks(target: Path) -> None:
    """Put the lectures and the course where Sphinx reads them; they run as pages do."""
    source = ROOT / "notebooks"
    lectures = {path.relative_to(source) for path in source.rglob("*.ipynb")}
    for name in sorted(lectures):
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        changed(target / name, (source / name).read_text())
    for path in target.rglob("*.ipynb"):
        if path.relative_to(target) not in lectures:
            path.unlink()


def write_settings(target: Path) -> str:
    """Write the kernel's settings into a folder of its own, whose name is returned."""
    profile = target / "profile_default"
    profile.mkdir(parents=True)
    (profile / "ipython_kernel_config.py").write_text(SETTINGS)
    return str(target)
