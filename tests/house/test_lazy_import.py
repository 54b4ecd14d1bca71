"""Importing the package is cheap; its names arrive on demand."""

import pkgutil
import subprocess
import sys
from importlib import import_module

import pytest

from tests.support.public import public_objects


@pytest.mark.parametrize(
    "statement", ["import compensator_theory", "import compensator_theory.errors"]
)
def test_import_leaves_heavy_packages_alone(statement):
    heavy = "{'sympy', 'numpy', 'control', 'hypothesis', 'flint', 'scipy', 'matplotlib'}"
    code = f"import sys; {statement}; print(sorted({heavy} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


@pytest.mark.costly
def test_a_file_is_verified_without_what_few_files_need():
    """Each of these takes a sixth of a second or more, in every worker and every command."""
    heavy = "{'scipy.stats', 'scipy.signal', 'scipy.optimize', 'control', 'matplotlib'}"
    code = (
        "import sys; from rcac_experiments import verify; "
        "from rcac_experiments.dissertation import load_example; "
        f"verify(load_example('1.1')); print(sorted({heavy} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_a_controller_needs_no_exact_theory():
    """What steps a controller is imported on machines that control; SymPy takes half a second."""
    heavy = "{'sympy', 'flint', 'scipy', 'control', 'matplotlib', 'hypothesis'}"
    code = (
        "from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir; "
        "update, target = UD(R_theta=1.0), TargetModel([0, 1]); "
        "settings = ControllerSettings(structure=iir(n_c=2), update=update, target=target); "
        "Controller(settings).step(z=1.0, y=1.0); "
        f"import sys; print(sorted({heavy} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_every_public_name_exists_and_is_documented():
    for name, value in public_objects("compensator_theory").items():
        assert value.__doc__, name


@pytest.mark.costly
@pytest.mark.parametrize("first", ["TransferFunction", "StandardProblem", "Realisation"])
def test_no_submodule_shadows_a_function(first):
    code = (
        f"from compensator_theory import {first}\n"
        "import compensator_theory as c\n"
        "from types import ModuleType\n"
        "spaces = [c, *(v for n in c.__all__ if isinstance(v := getattr(c, n), ModuleType))]\n"
        "names = [(s, n) for s in spaces if hasattr(s, '__all__') for n in s.__all__]\n"
        "assert len(names) > 200\n"
        "assert all(callable(getattr(s, n)) or s is c for s, n in names)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("package", ["compensator_theory", "rcac_numeric", "rcac_experiments"])
def test_a_name_that_stands_in_a_namespace_is_found_from_the_package(package):
    """`compensator_theory.tustin` names compensator_theory.sampling.tustin."""
    module = import_module(package)
    known = set(module.__all__)
    places = {n.rpartition(".")[2]: n for n in public_objects("compensator_theory")}
    inner = [name for name in public_objects(package) if "." in name] or ["sampling.tustin"]
    for name in (one.rpartition(".")[2] for one in [*inner, *places]):
        if name in known or name in vars(module):  # a folder that was imported is an attribute
            continue
        with pytest.raises(AttributeError, match=rf"it is [\w.]+\.{name}$") as caught:
            getattr(module, name)
        text = str(caught.value).rpartition(" ")[2]
        assert pkgutil.resolve_name(":".join(text.rsplit(".", 1))) is not None
    with pytest.raises(AttributeError, match=r"has no attribute 'nowhere'$"):
        getattr(module, "now" + "here")
