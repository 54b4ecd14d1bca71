"""Reports as web pages that need no network: one file each, for a browser in light or dark."""
