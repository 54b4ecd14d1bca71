"""The thumbnails at the head of the gallery: one panel of every picture of the page, as a link."""

from collections.abc import Iterator
from typing import Any

from docutils import nodes

PAGE = "gallery/index"
# A whole sheet cannot be read at this size. Left, top, width and height of the panel that is
# shown, all in widths of the picture.
PANELS = {
    "gallery-run": (0.640, 0.033, 0.330, 0.296),
    "gallery-compare": (0.011, 0.011, 0.520, 0.245),
    "gallery-design": (0.011, 0.005, 0.550, 0.265),
    "gallery-check": (0.680, 0.043, 0.313, 0.358),
    "gallery-margins": (0.009, 0.009, 0.385, 0.445),
    "gallery-disk": (0.010, 0.010, 0.980, 0.695),
    "gallery-lqg": (0.006, 0.006, 0.420, 0.430),
    "gallery-bode": (0.010, 0.010, 0.640, 0.325),
    "gallery-locus": (0.0, 0.0, 1.0, 1.090),
    "gallery-region": (0.0, 0.0, 1.0, 0.750),
    "gallery-observers": (0.006, 0.006, 0.490, 0.435),
    "gallery-zeros": (0.006, 0.006, 0.490, 0.435),
    "gallery-sampling": (0.667, 0.004, 0.330, 0.330),
}


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
    """A link with one panel of the picture and the title of each section of a task."""
    for section in task.children:
        if not isinstance(section, nodes.section):
            continue
        image = next(section.findall(nodes.image), None)
        title = section[0].astext()
        target = nodes.reference("", "", refid=section["ids"][0], internal=True)
        if image is not None:
            small = image.deepcopy()
            small["alt"] = ""  # the title says it
            for size in ("width", "height", "scale"):
                small.attributes.pop(size, None)
            target += _html(f'<span class="panel" style="{_crop(section)}">')
            target += small
            target += _html("</span>")
        target += nodes.inline("", title)
        yield nodes.list_item("", nodes.paragraph("", "", target))


def _crop(section: nodes.section) -> str:
    """The panel as properties of the style sheet: magnification, offsets, ratio of its sides."""
    names = {name for figure in section.findall(nodes.figure) for name in figure["ids"]}
    names |= {name for figure in section.findall(nodes.figure) for name in figure["names"]}
    left, top, width, height = next(
        (panel for name, panel in PANELS.items() if name in names), (0.0, 0.0, 1.0, 0.75)
    )
    return (
        f"--across: {1 / width:.4f}; --left: {left / width:.4f}; --top: {top / width:.4f}; "
        f"aspect-ratio: {width / height:.4f}"
    )


def _html(text: str) -> nodes.raw:
    return nodes.raw("", text, format="html")
