"""A threshold on u with a promise: from poses whose errors are known to the u up to which new ones can be trusted.

Run it with `python thresholds.py`. The poses are made up here: errors of 0 to 40 mm that u follows with noise.
"""

import numpy as np

from maskval import ImageErrors, match_images, paper_threshold, recall_curve, summarise

rng = np.random.default_rng(0)
images = []
for _ in range(400):  # each with one part and one pose of it
    error_m = float(rng.gamma(2.0, 0.004))
    u = float(np.clip(20.0 * error_m + rng.normal(0.0, 0.03), 0.0, 1.0))
    images.append(ImageErrors(np.array([[error_m]]), np.array([u]), np.ones(1)))
evaluation = match_images(images)

u_T = paper_threshold(evaluation, e_t=0.015)
print(f"the paper's rule at 15 mm: trust u up to {u_T:.3f}")
curve = recall_curve(evaluation, np.linspace(0.0, 0.03, 31))
print(f"area under the recall curve: {curve.auc:.2f}")
print(summarise(evaluation, e_t=0.015))
