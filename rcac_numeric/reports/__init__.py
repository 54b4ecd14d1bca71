"""Reports of results: in a terminal, as JSON, in a page."""
