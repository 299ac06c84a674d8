"""What a page shows of runs: what happened in their experiments, in words, outlines and command lines."""
