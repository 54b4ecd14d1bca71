"""The same run in certified ball arithmetic."""
