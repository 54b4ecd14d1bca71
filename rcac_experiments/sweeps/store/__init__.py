"""The SQLite file that a study is written to as its runs end."""
