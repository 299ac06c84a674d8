"""From a mesh, poses and a camera to silhouettes and depths: compiled kernels, and the NumPy references they equal."""
