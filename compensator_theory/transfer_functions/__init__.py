"""Transfer functions and their matrices: exact data, arithmetic, expansions."""
