"""From a mesh to a part: repair, convex pieces, stable poses, symmetries, grasps, slot. Geometry without the engine."""
