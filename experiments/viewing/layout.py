"""How the Rerun viewer shows a recording: which views there are, what they show and in which colours."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.observing.drawing import BLUE, MASK, RED
from sim.scenery.lighting import EYE, TARGET

Array = NDArray[np.float32]
WORLD, LOOK, U, DECISIONS = "world", "look", "u", "decisions"  # what the recording has at its root
MASKS = f"{WORLD}/look/camera/masks"
_DETECTIONS = 255  # that one picture of masks can number


def layout(rerun: Any, timeline: str) -> Any:
    """The cell in 3D as the overview sees it; beside it the newest look, u with its threshold, and the decisions.

    Args:
        rerun: the module.
        timeline: what time the viewer goes by.
    """
    views = rerun.blueprint
    eye = views.EyeControls3D(position=EYE, look_target=TARGET, eye_up=(0.0, 0.0, 1.0))
    return views.Blueprint(
        views.Horizontal(
            views.Spatial3DView(origin=WORLD, name="cell", eye_controls=eye, line_grid=False),
            views.Vertical(
                views.Spatial2DView(origin=LOOK, name="newest look: mask, model at the estimated pose, u"),
                views.TimeSeriesView(origin=U, name="u of the decisions, and the threshold"),
                views.TextLogView(
                    origin=DECISIONS,
                    name="states, decisions, outcomes",
                    columns=views.TextLogColumns(timeline_columns=[timeline], text_log_columns=["Body"]),
                ),
                row_shares=[4, 2, 3],
            ),
            column_shares=[5, 4],
        ),
        views.TimePanel(state="collapsed", timeline=timeline),
        views.BlueprintPanel(state="collapsed"),
        views.SelectionPanel(state="collapsed"),
        auto_views=False,
    )


def log_colours(rerun: Any, stream: Any) -> None:
    """Says once how masks and u are drawn: nothing where no mask is, u as points, the threshold in steps."""
    classes = [(0, "no detection", (0, 0, 0, 0))]
    classes += [(1 + index, f"detection {index}", (*MASK, 255)) for index in range(_DETECTIONS)]
    stream.log(MASKS, rerun.AnnotationContext(classes), static=True)
    points = rerun.SeriesPoints(colors=[BLUE], names=["u"], marker_sizes=[5.0])
    step = rerun.components.InterpolationMode.StepAfter
    lines = rerun.SeriesLines(colors=[RED], names=["threshold"], widths=[2.0], interpolation_mode=step)
    stream.log(f"{U}/decided", points, static=True)
    stream.log(f"{U}/threshold", lines, static=True)


def faceted(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> tuple[Array, Array]:
    """Three corners of each face, which it shares with none, and its normal at each: the viewer shades by normals.

    Args:
        vertices: (V, 3).
        faces: indices of vertices, (F, 3), counter-clockwise from outside.

    Returns:
        Corners and normals, (3 F, 3) each; the normal of a face without area is zero.
    """
    corners = vertices[faces].astype(np.float32)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    normals = np.divide(across, lengths, out=np.zeros_like(across), where=lengths > 0)
    return corners.reshape(-1, 3), np.repeat(normals, 3, axis=0)
