"""Learned networks: a detector and pose networks that look at the wrist camera's pictures. No MuJoCo, no truth."""
