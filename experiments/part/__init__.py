"""The command `part`: a part of the user's own from a mesh, and checks of part files."""
