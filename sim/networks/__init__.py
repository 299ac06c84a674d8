"""The simulated networks: from the truth about a picture to masks and poses with errors. No MuJoCo."""
