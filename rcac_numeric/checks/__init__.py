"""Health of a run or of a logged controller: warnings with next steps, replay of a log."""
