"""Files that are no experiment: too large, too deep, with text that a terminal would obey."""

import pytest

from compensator_theory import InputError
from rcac_experiments import load_experiment
from rcac_experiments.files._builder import build
from rcac_experiments.files._documents import LARGEST_FILE, read_file


@pytest.fixture
def file(tmp_path):
    def write(content):
        path = tmp_path / "case.toml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\x00\xff", "is not valid TOML"),
        ("x = [", "is not valid TOML"),
        ("x = " + "[" * 5000 + "]" * 5000, "nested more than"),
        ("x = " + "[" * 60 + "]" * 60, "nested more than"),
        ("x = " + "9" * 5000, "is not valid TOML"),
        ('title = "a\\u001b[31mb"', "control character '\\x1b'"),
        ('title = "a\\u202eb"', "control character '\\u202e'"),
        ('"a\\u0007" = 1', "control character '\\x07'"),
        (b"#" * (LARGEST_FILE + 1), "is larger than 10 MiB"),
    ],
)
def test_what_is_no_experiment(file, content, message):
    path = file(content)
    with pytest.raises(InputError) as refused:
        load_experiment(path)
    assert message in str(refused.value) and str(refused.value).startswith(str(path))
    assert len(str(refused.value)) < 2000


def test_a_file_without_end_is_not_read_to_its_end():
    with pytest.raises(InputError, match="not a regular file"):
        read_file("/dev/zero")


@pytest.mark.parametrize("path", ["missing.toml", ".", "a\0b.toml"])
def test_what_cannot_be_read(path):
    with pytest.raises(InputError, match="cannot be read"):
        load_experiment(path)


def test_a_title_may_have_accents_and_two_lines(file):
    table, _ = read_file(file('title = "Überlagerung\\n\\tzwei"'))
    assert table["title"] == "Überlagerung\n\tzwei"


def test_messages_are_bearable():
    """Whatever is quoted is shortened, also by those who do not know of files."""
    table = {"plant": {"problem": "standard", "A": [[0.5] * 3000], "B": [[1]], "C": [[1]],
                       "D_1": [[1]]}}  # fmt: skip
    with pytest.raises(InputError) as refused:
        build({**table, "target": {"model": "fir"}, "controller": {}, "run": {"steps": 5}}, "case")
    assert len(str(refused.value)) < 2000
    with pytest.raises(InputError) as refused:
        build({"x" * 10_000: 1, "plant": {}}, "case")
    assert len(str(refused.value)) < 2000


def test_a_byte_order_mark_is_no_part_of_a_file(file):
    """Editors of Windows write one; a second one is no TOML."""
    assert read_file(file("\ufeffx = 1"))[0] == read_file(file("x = 1"))[0] == {"x": 1}
    with pytest.raises(InputError, match="not valid TOML"):
        read_file(file("\ufeff\ufeffx = 1"))
