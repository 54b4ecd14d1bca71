"""What the packages make public, by name."""

import pkgutil

from docs.reference_pages import public_names, public_path


def public_objects(package):
    """Every public name of a package and of its namespaces, with what it stands for."""
    return {
        name: pkgutil.resolve_name(":".join(public_path(package, name).rsplit(".", 1)))
        for name in public_names(package)
    }
