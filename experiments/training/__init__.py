"""`graspcell train`: a detector and two pose networks from rendered pictures. The only package that knows PyTorch."""
