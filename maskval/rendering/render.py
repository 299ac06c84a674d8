"""pyrender as a second backend: an independent oracle for silhouettes and depth, and shaded poses for pictures.

It needs the extra `graspcell[render]` and OpenGL without a screen, and is not imported with `maskval`. MuJoCo may
render in the same process, if both use EGL: the platform is chosen once, before OpenGL is first imported.
"""

import os
from importlib import import_module
from types import ModuleType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.errors import InvalidArgumentError, MissingRendererError
from maskval.geometry import Pose, PoseLike, as_pose
from maskval.mesh import Mesh
from maskval.rendering.views import NEAR_M

FAR_M = 100.0
# OpenGL samples pixel i at i + 0.5.
GL_PIXEL_CENTER = 0.5
# From OpenCV's camera axes to OpenGL's: y up, z backwards.
R_GC = np.diag((1.0, -1.0, -1.0))
COLOUR = (0.95, 0.55, 0.15)


class Renderer:
    """Renders one mesh under many poses; holds an OpenGL context, so make few and `close` them, or use `with`.

    Args:
        mesh: The object.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center.
        colour: Red, green and blue of the object in pictures, in [0, 1].

    Raises:
        MissingRendererError: If pyrender or OpenGL without a screen is missing.
    """

    def __init__(
        self,
        mesh: Mesh,
        camera: Camera,
        *,
        pixel_center: float = GL_PIXEL_CENTER,
        colour: tuple[float, float, float] = COLOUR,
    ) -> None:
        self._gl = pyrender = _pyrender()
        self._camera = camera
        material = pyrender.MetallicRoughnessMaterial(
            baseColorFactor=(*colour, 1.0), metallicFactor=0.1, roughnessFactor=0.6
        )
        corners, normals = _both_sides(mesh)
        primitive = pyrender.Primitive(positions=corners, normals=normals, material=material)
        self._scene = pyrender.Scene(bg_color=(0.0, 0.0, 0.0, 0.0), ambient_light=(0.25, 0.25, 0.25))
        self._object = self._scene.add(pyrender.Mesh([primitive]))
        X_CG = np.eye(4)
        X_CG[:3, :3] = R_GC.T
        self._scene.add(_intrinsics(pyrender, camera, pixel_center), pose=X_CG)
        # A light at the camera, tilted so that faces of other directions differ.
        self._scene.add(pyrender.DirectionalLight(intensity=4.0), pose=X_CG @ Pose.from_rotvec((-0.5, 0.4, 0)).matrix)
        try:
            self._renderer: Any = pyrender.OffscreenRenderer(camera.width, camera.height)
        except Exception as error:  # whatever the platform's loader raises
            raise MissingRendererError(f"no OpenGL without a screen ({error}): install libegl1 and libgl1") from error
        _leave_display(self._renderer._platform)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Gives the OpenGL context back; what is closed renders no more."""
        if self._renderer is not None:
            self._renderer.delete()
            self._renderer = None

    def depth(self, X_CO: PoseLike) -> NDArray[np.float32]:
        """The z-depth of the object, (H, W), metres; 0 where it is not.

        Args:
            X_CO: Pose of the object in the camera frame.
        """
        depth: NDArray[np.float32] = self._render(X_CO, self._gl.RenderFlags.DEPTH_ONLY)
        return depth.copy()

    def silhouette(self, X_CO: PoseLike) -> NDArray[np.bool_]:
        """The pixels that the object covers, (H, W).

        Args:
            X_CO: Pose of the object in the camera frame.
        """
        return self.depth(X_CO) > 0

    def overlay(self, X_CO: PoseLike, image: NDArray[np.uint8], *, opacity: float = 0.7) -> NDArray[np.uint8]:
        """The picture with the shaded object laid over it, (H, W, 3), RGB.

        Args:
            X_CO: Pose of the object in the camera frame.
            image: The picture, (H, W, 3), RGB.
            opacity: How much of the picture the object hides, in [0, 1].
        """
        size = (self._camera.height, self._camera.width, 3)
        if image.shape != size or image.dtype != np.uint8 or not 0 <= opacity <= 1:
            raise InvalidArgumentError(
                f"image must be uint8 of shape {size} and opacity in [0, 1], but are {image.dtype} of {image.shape} "
                f"and {opacity}"
            )
        shaded, depth = self._render(X_CO, self._gl.RenderFlags.NONE)
        share = opacity * (depth > 0)[..., None]
        mixed: NDArray[np.uint8] = np.rint(share * shaded[..., :3] + (1 - share) * image).astype(np.uint8)
        return mixed

    def _render(self, X_CO: PoseLike, flags: int) -> Any:
        self._scene.set_pose(self._object, as_pose(X_CO).matrix)
        # pyrender's framebuffer has 4 samples a pixel, of which depth takes one that is not at the centre: 2 % of the
        # pixels of a silhouette were wrong. It asks for them by this name only.
        module: Any = import_module("pyrender.renderer")
        multisample = module.glRenderbufferStorageMultisample
        module.glRenderbufferStorageMultisample = lambda target, _samples, *rest: multisample(target, 0, *rest)
        try:
            return self._renderer.render(self._scene, flags)
        finally:
            module.glRenderbufferStorageMultisample = multisample


def _pyrender() -> ModuleType:
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    try:
        return import_module("pyrender")
    except ImportError as error:
        raise MissingRendererError(
            f"pyrender cannot be imported ({error}): pip install 'graspcell[render]', and libegl1 and libgl1"
        ) from error


def _leave_display(platform: Any) -> None:
    """Lets an EGL platform of pyrender end its context only: with the display it would end those of MuJoCo, too."""
    if not hasattr(platform, "_egl_display"):
        return
    egl = import_module("OpenGL.EGL")

    def delete_context() -> None:
        egl.eglMakeCurrent(platform._egl_display, egl.EGL_NO_SURFACE, egl.EGL_NO_SURFACE, egl.EGL_NO_CONTEXT)
        egl.eglDestroyContext(platform._egl_display, platform._egl_context)
        platform._egl_display = platform._egl_context = None

    platform.delete_context = delete_context


def _both_sides(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners and normals of each face and of its back, (6 F, 3): pyrender's depth leaves out what looks away.

    Each face has corners of its own: it is shaded flat, and its neighbours need not agree with it.
    """
    welded = mesh.edges.vertices_M + mesh.edges.centre_O
    faces = np.concatenate((mesh.edges.faces, mesh.edges.faces[:, ::-1]))
    normals = mesh.edges.planes_M[:3].T.astype(np.float64)
    return welded[faces].reshape(-1, 3), np.repeat(np.concatenate((normals, -normals)), 3, axis=0)


def _intrinsics(pyrender: ModuleType, camera: Camera, pixel_center: float) -> Any:
    """A camera of pyrender with these intrinsics: its own class knows no skew."""
    shift = GL_PIXEL_CENTER - pixel_center
    given = pyrender.IntrinsicsCamera(
        camera.fx, camera.fy, camera.cx + shift, camera.cy + shift, znear=NEAR_M, zfar=FAR_M
    )
    whole = given.get_projection_matrix(camera.width, camera.height)
    whole[0, 1] = -2.0 * camera.skew / camera.width  # y points up here

    class Intrinsics(pyrender.Camera):  # type: ignore[misc,name-defined]
        def get_projection_matrix(self, width: float | None = None, height: float | None = None) -> Any:
            return whole

    return Intrinsics(znear=NEAR_M, zfar=FAR_M)
