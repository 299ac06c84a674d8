"""What can go wrong in the simulated cell."""


class SimError(Exception):
    """Base of the errors of the simulation."""


class PartFileError(SimError, ValueError):
    """A part that is unknown, or whose file or mesh is unfit."""


class PartExtraError(SimError, RuntimeError):
    """What makes parts from meshes was asked for and is not installed."""


class PlacementError(SimError, RuntimeError):
    """No room on the belt for the parts that were asked for."""


class StartError(SimError, RuntimeError):
    """An experiment that does not begin with all parts at rest on the belt."""


class DivergenceError(SimError, RuntimeError):
    """The physics left the finite numbers, or MuJoCo warned that it did."""


class GraphicsError(SimError, RuntimeError):
    """No off-screen OpenGL: the system library is missing or does not work."""


class NoiseFileError(SimError, ValueError):
    """An error model that is unknown, or whose file is unfit."""


class NetworkError(SimError, RuntimeError):
    """Learned networks that are missing, unfit, or of another part; or what runs them is not installed."""


class MeshesMissingError(SimError, RuntimeError):
    """The optional meshes of the arm were asked for and are not installed."""


class ConditionsError(SimError, ValueError):
    """A disturbance out of its range."""


class EnvOptionError(SimError, ValueError):
    """An option of a learning environment that does not exist or is out of its range."""
