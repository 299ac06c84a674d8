"""`graspcell dataset`: the paper's dataset tables, on test images made here."""
