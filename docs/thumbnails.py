"""The thumbnails at the head of the gallery: every picture of the page again, small, as a link."""

from collections.abc import Iterator
from typing import Any

from docutils import nodes

PAGE = "gallery/index"


def insert_thumbnails(app: Any, tree: nodes.document, page: str) -> None:
    """Put a list of small pictures for each task where the page has its container for them."""
    if page != PAGE:
        return
    (place,) = (node for node in tree.findall(nodes.container) if "thumbnails" in node["classes"])
    for task in tree.findall(nodes.section):
        pictures = list(_pictures(task))
        if pictures and not isinstance(task.parent, nodes.document):
            place += nodes.rubric("", task[0].astext())
            place += nodes.bullet_list("", *pictures, classes=["thumbnails"])


def _pictures(task: nodes.section) -> Iterator[nodes.list_item]:
    """A link with the picture and the title of each section of a task."""
    for section in task.children:
        if not isinstance(section, nodes.section):
            continue
        image = next(section.findall(nodes.image), None)
        title = section[0].astext()
        target = nodes.reference("", "", refid=section["ids"][0], internal=True)
        if image is not None:
            small = image.deepcopy()
            small["alt"] = ""  # the title says it
            target += small
        target += nodes.inline("", title)
        yield nodes.list_item("", nodes.paragraph("", "", target))
