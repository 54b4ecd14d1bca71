"""The statements of the dissertation and their evidence, checked by machine."""
