"""The running cell: physics, the robot's station, the referee, and an episode set up from them."""
