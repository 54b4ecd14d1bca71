"""A controller as C that runs without Python: on a board, in a browser, in a simulator."""
