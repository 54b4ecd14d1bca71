"""What the files of all experiments begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypedDict

import attrs

NUMBER_AND_SOURCE = (
    "Its number, the name of the file where it is left out; and where it comes from."
)


class HeadingWords(TypedDict):
    """What an experiment takes from its heading."""

    id: str
    title: str
    source: str
    notes: str


@attrs.frozen(eq=False, kw_only=True)
class Heading:
    """What an experiment is about."""

    title: Annotated[str, "What it is about, in a line."] = ""
    id: Annotated[str, NUMBER_AND_SOURCE] = ""
    source: Annotated[str, NUMBER_AND_SOURCE] = ""
    notes: Annotated[str, "What a reader of the report should know."] = ""

    def words(self, file: str) -> HeadingWords:
        """What the experiment of this file takes from it."""
        return {
            "id": self.id or Path(file).stem,
            "title": self.title,
            "source": self.source,
            "notes": self.notes.strip(),
        }
