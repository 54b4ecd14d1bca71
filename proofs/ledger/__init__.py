"""The ledger: its entries, the checks that they name, and what became of each."""
