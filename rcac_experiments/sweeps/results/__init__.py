"""What a study came to: tables, statistics, single runs again."""
