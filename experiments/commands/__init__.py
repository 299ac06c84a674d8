"""The commands of `graspcell` about the running cell and about a user's own poses, with the options of each."""
