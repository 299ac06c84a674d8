"""A rule for the learning environment: grasp the least uncertain detection, search on above a threshold.

Run it with `python decide.py`; `python decide.py 1` plays an episode of one part.
"""

import sys

import gymnasium
import numpy as np

THRESHOLD = 0.3  # of MaskVal's u


def decide(observation):
    """The action: 0 searches on, 1 + N + k grasps detection k of N."""
    u = np.where(observation["valid"] == 1, observation["u_maskval"], np.inf)
    best = int(u.argmin())
    return 1 + len(u) + best if u[best] <= THRESHOLD else 0


def main():
    """Plays one episode and tells what happened."""
    parts = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    env = gymnasium.make("graspcell:GraspCell-v0", part="antenna", n_parts=parts)
    observation, info = env.reset(seed=0)
    over = False
    while not over:
        action = decide(observation)
        observation, _, terminated, truncated, info = env.step(action)
        over = terminated or truncated
        for event in info["events"]:
            print(f"{event['time']:6.1f} s: {event['outcome']}")
    print(f"{info['count']['tp']} of {parts} placed")
    env.close()


if __name__ == "__main__":
    main()
