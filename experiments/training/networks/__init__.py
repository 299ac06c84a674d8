"""The networks and how they are trained: all that needs PyTorch, which only `graspcell train` does."""
