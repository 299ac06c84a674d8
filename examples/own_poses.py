"""How far can a pose be trusted? MaskVal's u of right and wrong poses, from a mesh, masks and a camera alone.

Run it with `python own_poses.py`; nothing of the cell is needed.
"""

import numpy as np

from maskval import Camera, Mesh, Pose, silhouette, uncertainty

# A wedge, 120 × 60 × 40 mm: no two of its sides look alike.
VERTICES = np.array([[0, 0, 0], [0.12, 0, 0], [0.12, 0.06, 0], [0, 0.06, 0], [0, 0, 0.04], [0, 0.06, 0.04]])
FACES = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [3, 5, 2], [1, 2, 5], [1, 5, 4], [0, 4, 5], [0, 5, 3]])

mesh = Mesh(VERTICES, FACES)
camera = Camera.from_K(np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]]), 640, 480)
true_pose = Pose.from_rotvec((2.4, 0.3, 0.2), (0.02, -0.01, 0.6))  # X_CO: the object in the camera's frame, m

# What a detector would give: here the exact mask of the true pose.
mask = silhouette(mesh, true_pose, camera).mask
wrong = {
    "the true pose": Pose.identity(),
    "5 mm aside": Pose.from_translation((0.005, 0.0, 0.0)),
    "50 mm farther away": Pose.from_translation((0.0, 0.0, 0.05)),
    "turned by 20 degrees": true_pose @ Pose.from_rotvec((0.0, 0.0, np.radians(20))) @ true_pose.inverse(),
}
poses = [error @ true_pose for error in wrong.values()]
found = uncertainty(mesh, poses, np.repeat(mask[np.newaxis], len(poses), axis=0), camera)
for name, u in zip(wrong, found.u, strict=True):
    print(f"{name:22} u = {u:.3f}")
