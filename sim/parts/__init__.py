"""Parts: their files with what is valid, meshes, made surfaces, stable poses and symmetries. No engine."""
