"""Moving pictures of experiments, by running them again."""
