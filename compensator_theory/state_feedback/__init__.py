"""State feedback and output injection for several signals: every gain, by what it leaves free."""
