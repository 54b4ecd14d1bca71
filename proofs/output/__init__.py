"""The ledger as a person, a program or the documentation reads it."""
