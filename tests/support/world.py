"""Rows of a table of public cases: where each comes from, what was asked, what is right."""

import pytest


def case(source, *row, open_because=""):
    """One row: `source` is its name; `open_because` is why it is still wrong here."""
    marks = [pytest.mark.xfail(strict=True, reason=open_because)] if open_because else []
    return pytest.param(*row, id=source.replace(" ", "-"), marks=marks)
