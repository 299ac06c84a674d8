"""Statistics for decisions: which method is better, how many experiments tell it, and when to stop. Numbers only."""
