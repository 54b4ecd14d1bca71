"""What pages with code cells need: the lectures among them, and how their kernel draws."""

from pathlib import Path

from docs.reference_pages import ROOT, changed

SETTINGS = """c.InteractiveShellApp.matplotlib = "inline"
c.InlineBackend.figure_formats = {"retina"}
"""


def copy_notebooks(target: Path) -> None:
    """Put the lectures of the folder notebooks where Sphinx reads them; they run as pages do."""
    target.mkdir(exist_ok=True)
    lectures = sorted((ROOT / "notebooks").glob("*.ipynb"))
    for path in lectures:
        changed(target / path.name, path.read_text())
    for path in target.glob("*.ipynb"):
        if path.name not in {lecture.name for lecture in lectures}:
            path.unlink()


def write_settings(target: Path) -> str:
    """Write the kernel's settings into a folder of its own, whose name is returned."""
    profile = target / "profile_default"
    profile.mkdir(parents=True)
    (profile / "ipython_kernel_config.py").write_text(SETTINGS)
    return str(target)
