"""`python -m sim.model.opengl`: renders one small picture, to see whether the OpenGL of `MUJOCO_GL` works."""

import mujoco

from sim.model.renderer import Renderer


def render_once() -> None:
    """Renders a ball.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
    """
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom size='0.1'/><camera name='eye' pos='0 0 1'/></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = Renderer(model, 16, 16)
    camera.rgb(data, "eye")
    camera.close()


if __name__ == "__main__":
    render_once()
