"""The rules of the house for the C++ kernel: layers of folders, sizes, no include circle."""

import re
from pathlib import Path

import pytest

KERNEL = Path(__file__).resolve().parents[2] / "kernel"
# From the ground up: a folder includes itself and what stands on a floor below its own.
FLOORS = [
    {"memory", "polynomials", "simd"},
    {"updates", "plants"},
    {"controller", "estimation", "identification"},
    {"loop"},
    {"lanes"},
    {"bindings"},
]
LARGEST_FOLDER, LONGEST_FILE = 12, 600

ALONE = KERNEL / "core"  # C that is exported: neither side includes the other

FILES = sorted(
    p for p in KERNEL.rglob("*") if p.suffix in (".hpp", ".cpp") and ALONE not in p.parents
)
NAMES = [str(p.relative_to(KERNEL)) for p in FILES]
OURS = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
ANY = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)


def floor(name):
    """The floor of a file's first folder; simd/lanes belongs to simd."""
    return next(i for i, folders in enumerate(FLOORS) if Path(name).parts[0] in folders)


def upward(name, text):
    """What a file includes that stands neither in its own folder nor on a lower floor."""
    return [
        other
        for other in OURS.findall(text)
        if Path(other).parts[0] != Path(name).parts[0] and floor(other) >= floor(name)
    ]


def foreign(text):
    """What a file that is compiled once per instruction set may not include.

    An inline function of a shared header would be compiled for several instruction sets, and the
    linker would be free to keep the copy that this processor cannot run.
    """
    return [
        other
        for other in ANY.findall(text)
        if not other.startswith("simd/") and other != "cstddef"  # types and nothing else
    ]


def circle(includes):
    """A list of files each of which includes the next, or None."""
    done, path = set(), []

    def visit(name):
        if name in path:
            return [*path[path.index(name) :], name]
        if name in done:
            return None
        path.append(name)
        result = next(filter(None, map(visit, includes[name])), None)
        path.pop()
        done.add(name)
        return result

    return next(filter(None, map(visit, includes)), None)


@pytest.mark.parametrize("name", NAMES)
def test_arrows_go_down(name):
    text = (KERNEL / name).read_text()
    assert not upward(name, text)
    assert {other for other in OURS.findall(text) if other not in NAMES} == set()


@pytest.mark.parametrize("name", [n for n in NAMES if n.startswith("simd/")])
def test_simd_includes_nothing_from_outside(name):
    if name != "simd/dispatch.cpp":  # it chooses, and is compiled once for every processor
        assert not foreign((KERNEL / name).read_text())


def test_no_include_circle():
    includes = {n: OURS.findall((KERNEL / n).read_text()) for n in NAMES}
    assert circle(includes) is None


def test_folders_and_files_are_small():
    for folder in {p.parent for p in FILES}:
        assert len([p for p in FILES if p.parent == folder]) <= LARGEST_FOLDER, folder
    for path in FILES:
        assert len(path.read_text().splitlines()) <= LONGEST_FILE, path
        assert path.suffix == ".cpp" or "#pragma once" in path.read_text(), path


def test_the_core_stands_alone():
    """The two files that are compiled on a board need three headers, none of which is a library."""
    text = "".join((ALONE / name).read_text() for name in ("rcac.c", "rcac.h"))
    assert set(ANY.findall(text)) == {
        "rcac.h", "rcac_config.h", "stdint.h", "stddef.h", "string.h"
    }  # fmt: skip
    assert not any("core/" in path.read_text() for path in FILES)


def test_the_floors_are_the_tree():
    result = {p.name for p in KERNEL.iterdir() if p.is_dir()} - {ALONE.name}
    assert result == set().union(*FLOORS)
    assert sum(map(len, FLOORS)) == len(result)


def test_these_rules_can_be_broken():
    assert upward("memory/a.hpp", '#include "simd/layout.hpp"') == ["simd/layout.hpp"]
    assert upward("updates/a.hpp", '  #include "plants/plant.hpp"') == ["plants/plant.hpp"]
    assert upward("loop/a.hpp", '#include "bindings/replay.hpp"') == ["bindings/replay.hpp"]
    assert not upward("simd/lanes/a.hpp", '#include "simd/layout.hpp"\n#include <vector>')
    assert foreign('#include <cstddef>\n#include <vector>\n#include "memory/aligned.hpp"') == [
        "vector",
        "memory/aligned.hpp",
    ]
    assert circle({"a": ["b"], "b": ["c"], "c": ["b"]}) == ["b", "c", "b"]
    assert circle({"a": ["b", "c"], "b": ["c"], "c": []}) is None
