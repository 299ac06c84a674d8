"""What can be wrong with the input of this package."""


class MaskvalError(Exception):
    """Base of every error that this package raises on purpose."""


class InvalidPoseError(MaskvalError, ValueError):
    """A rotation that is none, a translation of another shape, or a point that has no image."""


class InvalidCameraError(MaskvalError, ValueError):
    """A camera matrix that no pinhole camera has, or an image without pixels."""


class InvalidMeshError(MaskvalError, ValueError):
    """A mesh without faces, with indices out of range, or in millimetres."""


class InvalidMaskError(MaskvalError, ValueError):
    """A mask that is not binary or of another size than the image."""


class InvalidEstimatesError(MaskvalError, ValueError):
    """Detections whose masks, poses and scores do not belong together, or a parameter out of its range."""


class InvalidEvaluationError(MaskvalError, ValueError):
    """Errors, uncertainties and parts that do not belong together, or a metric's parameter out of its range."""


class InvalidFileError(MaskvalError, ValueError):
    """A file that is not of the format that it should be; the message begins with the file and the place in it."""


class InexactRotationWarning(UserWarning):
    """Rotations of a file were rounded to few digits, or not orthonormal to begin with; the nearest ones are taken."""


class InvalidArgumentError(MaskvalError, ValueError):
    """An argument that is of another kind, or out of its range."""


class ImplausibleInputError(MaskvalError, ValueError):
    """Poses, masks and cameras that are well-formed but certainly do not fit; the message names the likely cause."""


class ImplausibleInputWarning(UserWarning):
    """Input that is probably not what was meant; the message says what is odd about it."""


class MissingRendererError(MaskvalError, ImportError):
    """pyrender, or OpenGL without a screen, which only `maskval.rendering.render` needs, is not there."""
