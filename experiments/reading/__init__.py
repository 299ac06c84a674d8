"""Reading runs: their tables, questions to them in SQL, and their experiments simulated again."""
