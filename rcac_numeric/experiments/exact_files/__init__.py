"""The files of exact examples, read as experiments that run nothing."""
