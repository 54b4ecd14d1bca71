"""Riccati equations propagated forward, and the indirect adaptive loop that lives from them."""
