"""What an uncertainty method is given, and what it must offer."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.errors import InvalidEstimatesError
from maskval.geometry import Pose
from maskval.mesh import Mesh


