"""`graspcell uq`: the uncertainty of every pose of a BOP submission, and how good it is."""
