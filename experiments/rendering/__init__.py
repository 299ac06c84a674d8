"""`graspcell render-dataset`: pictures with their truth, as BOP datasets."""
