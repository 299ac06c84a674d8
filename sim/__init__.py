"""The cell in MuJoCo: the only package that knows the engine, and the only one that knows the truth."""
