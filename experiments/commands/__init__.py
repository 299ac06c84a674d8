"""The commands of `graspcell` about the running cell and about poses of one's own, with what a person sets for each."""
