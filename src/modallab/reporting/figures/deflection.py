"""A structure that moves, as a picture and as a moving one that any browser and any slide shows."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modallab.core.arrays import Complex128, Real
from modallab.core.rig import Rig
from modallab.formats.atomic import replacing
from modallab.modification.deflection import rotate_to_real
from modallab.modification.mesh import Wireframe
from modallab.reporting.figures import style
from modallab.reporting.figures.wireframe import drawing_projection, is_spatial

FRAMES, FPS = 24, 12
REACH = 0.15
"""Of the structure's size: its largest motion as it is drawn."""
FROM_THE_SIDE = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
"""(3, 2): x to the right, y and z up, for points along a line."""


class Drawing:
    """Lines and points of a structure in parallel projection, to be drawn at any phase of its motion."""

    def __init__(self, rig: Rig, motion: Complex128, title: str) -> None:
        """Make the figure at phase 0.

        Args:
            rig: points, and lines between them; without lines, points are joined in the order of x, from a clamp on.
            motion: (points, 3) complex, along x, y, z.
            title: over it.
        """
        real = rotate_to_real(motion.ravel()).reshape(motion.shape)
        self.rest, self.moved, self.pairs = project_shape(rig, real, float(np.abs(motion).max()) or 1.0)
        with style.figure_style():
            self.figure, (axes,) = style.panel_grid(1, 1, style.PanelSize(560, 280))
            self._frame(axes, title)

    def _frame(self, axes: Axes, title: str) -> None:
        axes.set_axis_off()
        axes.set_title(style.shorten_text(title, 70))
        axes.set_aspect("equal")
        for a, b in self.pairs:
            axes.plot(*self.rest[[a, b]].T, color=style.GRID, linewidth=1.2, zorder=1)
        self.lines = [axes.plot([], [], color=style.MEASURED, linewidth=1.8, zorder=2)[0] for _ in self.pairs]
        self.dots = axes.plot([], [], "o", color=style.MODEL, markersize=4, zorder=3)[0]
        far = np.abs(self.moved)
        (left, low), (right, high) = (self.rest - far).min(axis=0), (self.rest + far).max(axis=0)
        edge = 0.03 * max(right - left, high - low)
        axes.set_xlim(left - edge, right + edge)
        axes.set_ylim(low - edge, high + edge)
        self.at(0.0)

    def at(self, phase: float) -> Figure:
        """The figure at a phase of the motion in rad."""
        now = self.rest + np.real(self.moved * np.exp(1j * phase))
        for line, (a, b) in zip(self.lines, self.pairs, strict=True):
            line.set_data(*now[[a, b]].T)
        self.dots.set_data(*now.T)
        return self.figure

    def save(self, path: Path) -> None:
        """Write one swing as a GIF that goes on for ever.

        Raises:
            StorageError: the file cannot be written.
        """
        with TemporaryDirectory() as folder:
            written, writer = Path(folder) / "moving.gif", PillowWriter(fps=FPS)
            with style.figure_style(), writer.saving(self.figure, str(written), style.PX_PER_INCH):
                for n in range(FRAMES):
                    self.at(2 * np.pi * n / FRAMES)
                    writer.grab_frame()
            with replacing(path) as draft:
                draft.write_bytes(written.read_bytes())


def project_shape(rig: Rig, motion: Complex128, reach: float) -> tuple[Real, Complex128, list[tuple[int, int]]]:
    """(points, 2) places at rest and (points, 2) motion in projection, and the pairs of points that are joined.

    Args:
        rig: points, and lines between them.
        motion: (points, 3) complex, along x, y, z.
        reach: motion that is drawn as `REACH` of the structure's size.
    """
    skeleton = Wireframe.of(rig)
    xyz = skeleton.places_m
    size = float(np.ptp(xyz, axis=0).max()) or 1.0
    flat = drawing_projection() * np.array([1.0, -1.0]) if is_spatial(rig) else FROM_THE_SIDE
    moved = np.asarray(skeleton.displaced(motion) @ flat, np.complex128) * (REACH * size / reach)
    return xyz @ flat, moved, list(skeleton.lines)
