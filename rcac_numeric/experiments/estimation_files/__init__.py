"""The files of estimation examples: their tables, and the experiments that they make."""
