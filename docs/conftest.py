"""What the tests of the docs leave to Sphinx: its settings, and pages that it makes."""

collect_ignore = [
    "browse.py",
    "conf.py",
    "equation_links.py",
    "thumbnails.py",
    "notebooks",
    "reference",
    "_build",
]
