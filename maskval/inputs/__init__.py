"""What the package is given, checked: arrays and numbers, files, names."""
