"""The ledger: its entries, the checks that they name, and the outcome of each."""
