"""`graspcell gap` and `graspcell predict`: the domain gap fitted in the loop, and the robot table predicted."""
