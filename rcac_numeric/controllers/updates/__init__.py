"""How theta is updated, and the rules that change an update while it runs."""
