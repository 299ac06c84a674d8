"""moderngl: the least OpenGL can do, a bare shader into a buffer of one channel."""

from functools import cache

import moderngl
import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose

NEAR, FAR = 0.01, 10.0
VERTEX = "#version 330\nuniform mat4 P; in vec3 p; out float z; void main() { gl_Position = P * vec4(p, 1); z = %s; }"
MASK = "#version 330\nin float z; out float c; void main() { c = 1.0; }"
DEPTH = "#version 330\nin float z; out float c; void main() { c = z; }"


@cache
def shared_context() -> moderngl.Context:
    """One context for all meshes and sizes: with several, each draw would have to change the current one."""
    return moderngl.create_standalone_context(backend="egl")


class Contender:
    """R8 for the mask, R32F with a depth buffer for the depth, back faces culled."""

    PIXEL_CENTER = 0.5

    def __init__(self, mesh: Mesh, camera: Camera) -> None:
        self._context = context = shared_context()
        self._size = (camera.width, camera.height)
        vertices = context.buffer(mesh.vertices.astype("f4").tobytes())
        faces = context.buffer(mesh.faces.astype("i4").tobytes())
        self._programs = [
            context.program(vertex_shader=VERTEX % "gl_Position.w", fragment_shader=shader) for shader in (MASK, DEPTH)
        ]
        self._arrays = [context.vertex_array(program, [(vertices, "3f", "p")], faces) for program in self._programs]
        self._flat = context.framebuffer([context.renderbuffer(self._size, 1, dtype="f1")])
        self._deep = context.framebuffer(
            [context.renderbuffer(self._size, 1, dtype="f4")], context.depth_renderbuffer(self._size)
        )
        context.enable(moderngl.CULL_FACE)
        width, height = self._size
        # Row 0 of the buffer is the image's first: v grows with y, which turns the faces' sense.
        context.front_face = "cw"
        self._projection = np.array(
            (
                (2 * camera.fx / width, 0, 2 * camera.cx / width - 1, 0),
                (0, 2 * camera.fy / height, 2 * camera.cy / height - 1, 0),
                (0, 0, (FAR + NEAR) / (FAR - NEAR), -2 * FAR * NEAR / (FAR - NEAR)),
                (0, 0, 1, 0),
            )
        )

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        self._context.disable(moderngl.DEPTH_TEST)
        return self._draw(0, self._flat, X_CO, "f1").view(np.bool_)

    def depth(self, X_CO: Pose) -> NDArray[np.float32]:
        self._context.enable(moderngl.DEPTH_TEST)
        return self._draw(1, self._deep, X_CO, "f4").view(np.float32)

    def _draw(self, index: int, target: moderngl.Framebuffer, X_CO: Pose, kind: str) -> NDArray[np.uint8]:
        self._programs[index]["P"].write((self._projection @ X_CO.matrix).T.astype("f4").tobytes())
        target.use()
        target.clear()
        self._arrays[index].render()
        pixels = np.frombuffer(target.read(components=1, dtype=kind, alignment=1), np.uint8)
        return pixels.reshape(self._size[1], -1)
