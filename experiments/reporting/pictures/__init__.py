"""Pictures of attempts, by simulating their experiments again."""
