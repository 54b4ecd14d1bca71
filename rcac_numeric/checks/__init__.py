"""A logged controller, whatever program it ran in, replayed and analysed."""
