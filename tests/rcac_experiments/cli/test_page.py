"""`rcac verify --page`: one file, refused early where it cannot be."""

import pytest
from click.testing import CliRunner

from rcac_experiments.cli._main import main
from tests.support.pages import Page


@pytest.mark.costly
def test_a_case_of_a_users_own_gets_a_page(tmp_path):
    file = tmp_path / "own.html"
    result = CliRunner().invoke(
        main, ["verify", "examples/boost_converter.toml", "--page", str(file)]
    )
    assert result.exit_code == 0 and f"Page: {file}" in result.stdout
    page = Page(file.read_text())
    assert not page.open and len(page.all("svg")) == 4
    assert "The last step command is followed." in page.text


def test_a_name_or_folder_that_will_not_do_is_refused_before_anything_runs(tmp_path):
    for name, words in (("page.pdf", "must end in .html"), ("no/page.html", "no folder")):
        result = CliRunner().invoke(main, ["verify", "4.6", "--page", str(tmp_path / name)])
        assert result.exit_code == 2 and words in " ".join(result.output.split())
