"""Settings of a design found by trying, also over processes and into the store of a study."""
