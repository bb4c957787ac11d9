"""The scene of a film: what stands still is drawn once, what moves anew for each frame."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from helimag.plots._path import extent, frame_box
from helimag.plots._quantities import Shown, shown
from helimag.plots._series import draw_height
from helimag.plots._shapes import arrow_line, axis_rotation, body_rotation, cylinder_faces, head_faces, helix_line
from helimag.plots._style import BLUE, GREEN, GREY, ORANGE, PALE, PURPLE, SKY, VERMILLION
from helimag.trajectory import Trajectory

Floats = NDArray[np.float64]

WIDTH, HEIGHT = 1280, 720  # dots
DOTS_PER_INCH = 100
DEVICE_SHARE = 0.12  # of the scene's size: the device is enlarged to about this
FILM = {"font.size": 10.0, "axes.labelsize": 10.0, "xtick.labelsize": 9.0, "ytick.labelsize": 9.0, "lines.linewidth": 1.6}


class Scene:
    """Draws single samples of a run. Make it, and use it, within the style.

    Parameters
    ----------
    trajectory
        The run. Without a scenario, an orientation or a magnet, what needs them is left out.
    remark
        Written at the foot of every frame.
    """

    def __init__(self, trajectory: Trajectory, remark: str) -> None:
        self.run = shown(trajectory)
        self.data = {name: np.asarray(trajectory.dataset[name].values) for name in trajectory.dataset.data_vars}
        self.size = float(np.max(np.subtract(*extent(self.run)[::-1])))
        self.figure = Figure(figsize=(WIDTH / DOTS_PER_INCH, HEIGHT / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
        self.canvas = FigureCanvasAgg(self.figure)
        self.moving: list[tuple[Axes, Any]] = []
        self._stage(remark)
        self._cast()
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)  # type: ignore[attr-defined]

    @property
    def enlargement(self) -> float:
        """How many times its size the device is drawn in the whole scene."""
        if self.run.scenario is None:
            return 1.0
        device = self.run.scenario.device
        length = 1e3 * (device.helix.length + 2.0 * device.head.reach)
        return float(max(1, round(DEVICE_SHARE * self.size / length)))

    @property
    def has_body(self) -> bool:
        """Whether shape and orientation of the device are known."""
        return self.run.scenario is not None and "quaternion" in self.data

    def _stage(self, remark: str) -> None:
        """What stands still."""
        run = self.run
        self.figure.text(0.02, 0.965, run.name, weight="bold", fontsize=14, va="top")
        self.figure.text(0.02, 0.92, run.verdict, fontsize=10.5, va="top")
        self.figure.text(0.02, 0.02, remark, fontsize=9, color="#555555")
        self.whole: Axes3D = self.figure.add_axes((0.0, 0.07, 0.55, 0.82), projection="3d")  # type: ignore[assignment]
        low, high = extent(run)
        frame_box(self.whole, low, high)
        if run.magnet is not None:
            self.whole.plot(*run.magnet.T, color=PALE, linewidth=1.2)
        height = self.figure.add_axes((0.65, 0.13, 0.28, 0.24))
        draw_height(height, run)
        for line in height.lines[:1]:
            line.set(color=SKY, linewidth=0.8)
        height.set(xlim=(run.time[0], max(run.time[-1], run.time[0] + 1e-9)), xlabel="time (s)")
        self.height = height
        if self.has_body:
            self._stage_close_up()

    def _stage_close_up(self) -> None:
        assert self.run.scenario is not None
        device = self.run.scenario.device
        self.reach = 1.05e3 * (device.helix.length + 2.0 * device.head.reach)
        axes: Axes3D = self.figure.add_axes((0.58, 0.4, 0.42, 0.5), projection="3d")  # type: ignore[assignment]
        frame_box(axes, np.full(3, -self.reach), np.full(3, self.reach))
        axes.set(xlabel="", ylabel="", zlabel="")
        self.figure.text(0.6, 0.885, "device, to scale (mm from its head)", fontsize=10)
        for left, colour, text in ((0.6, GREEN, "field"), (0.655, PURPLE, "device's moment")):
            self.figure.text(left, 0.855, text, fontsize=10, color=colour, weight="bold")
        self.close_up = axes

    def _cast(self) -> None:
        """What moves."""
        self.clock = self._move(self.whole, self.figure.text(0.02, 0.865, "", fontsize=12, family="monospace"))
        self.path = self._move(self.whole, self.whole.plot([], [], [], color=BLUE, linewidth=1.4)[0])
        self.head = self._move(self.whole, self.whole.plot([], [], [], "o", color=BLUE, markersize=4)[0])
        self.so_far = self._move(self.height, self.height.plot([], [], color=BLUE)[0])
        self.now = self._move(self.height, self.height.plot([], [], "o", color=BLUE, markersize=5)[0])
        if self.run.magnet is not None and self.run.scenario is not None and "rpm_moment" in self.data:
            faces, north = cylinder_faces(self.run.scenario.magnet[0])
            self.faces = 1e3 * np.concatenate(faces)
            self.splits = np.cumsum([len(face) for face in faces])[:-1]
            colours = [VERMILLION if upper else BLUE for upper in north]
            self.magnet = self._solid(self.whole, colours)
            self.moment = self._move(self.whole, self.whole.plot([], [], [], color="black", linewidth=2.0)[0])
        if self.has_body:
            assert self.run.scenario is not None
            self.helix = 1e3 * helix_line(self.run.scenario.device)
            self.ball = 1e3 * np.stack(head_faces(self.run.scenario.device))
            self.bodies = [self._body(self.whole, 2.0), self._body(self.close_up, 4.5)]
            self.device_moment = self._move(
                self.close_up, self.close_up.plot([], [], [], color=PURPLE, linewidth=2.5)[0]
            )
        if "field" in self.data:
            self.fields = [self._move(self.whole, self.whole.plot([], [], [], color=GREEN, linewidth=2.0)[0])]
            if self.has_body:
                self.fields.append(self._move(self.close_up, self.close_up.plot([], [], [], color=GREEN, linewidth=2.5)[0]))

    def _move(self, axes: Axes, artist: Any) -> Any:
        artist.set_animated(True)
        self.moving.append((axes, artist))
        return artist

    def _solid(self, axes: Axes3D, colours: Any) -> Poly3DCollection:
        solid = Poly3DCollection([np.zeros((3, 3))], facecolors=colours, edgecolors="#00000030", linewidths=0.3)
        axes.add_collection3d(solid, autolim=False)
        self._move(axes, solid)
        return solid

    def _body(self, axes: Axes3D, width: float) -> tuple[Any, Poly3DCollection]:
        helix = self._move(axes, axes.plot([], [], [], color=ORANGE, linewidth=width, solid_capstyle="round")[0])
        return helix, self._solid(axes, GREY)

    def frame(self, sample: int) -> NDArray[np.uint8]:
        """Draw one sample: (height, width, 3) red, green, blue."""
        self._place(sample)
        self.canvas.restore_region(self.background)  # type: ignore[attr-defined]
        for axes, artist in self.moving:
            if isinstance(artist, Poly3DCollection):
                artist.do_3d_projection()
            axes.draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()

    def _place(self, sample: int) -> None:
        run = self.run
        here = run.position[sample]
        field = self.data["field"][sample] if "field" in self.data else None
        self.clock.set_text(
            f"t = {run.time[sample]:7.1f} s   z = {here[2]:7.1f} mm"
            + ("" if field is None else f"   field {1e3 * np.linalg.norm(field):6.2f} mT")
        )
        self.path.set_data_3d(*run.position[: sample + 1].T)
        self.head.set_data_3d(*here[:, None])
        self.so_far.set_data(run.time[: sample + 1], run.position[: sample + 1, 2])
        self.now.set_data([run.time[sample]], [here[2]])
        if hasattr(self, "magnet"):
            self._place_magnet(sample)
        if self.has_body:
            self._place_body(sample, here)
        if field is not None and np.linalg.norm(field) > 0.0:
            direction = field / np.linalg.norm(field)
            self.fields[0].set_data_3d(*arrow_line(here, 0.16 * self.size * direction, _view(self.whole)).T)
            for arrow in self.fields[1:]:
                arrow.set_data_3d(*arrow_line(np.zeros(3), 0.9 * self.reach * direction, _view(self.close_up)).T)

    def _place_magnet(self, sample: int) -> None:
        assert self.run.magnet is not None
        centre = self.run.magnet[sample]
        moment = self.data["rpm_moment"][sample]
        direction = moment / np.linalg.norm(moment)
        self.magnet.set_verts(np.split(centre + self.faces @ axis_rotation(direction).T, self.splits))
        length = 1.6 * float(np.abs(self.faces).max())
        self.moment.set_data_3d(*arrow_line(centre, length * direction, _view(self.whole)).T)

    def _place_body(self, sample: int, here: Floats) -> None:
        rotation = body_rotation(self.data["quaternion"][sample])
        for (helix, ball), centre, scale in zip(self.bodies, (here, np.zeros(3)), (self.enlargement, 1.0), strict=True):
            helix.set_data_3d(*(centre + scale * self.helix @ rotation.T).T)
            ball.set_verts(list(centre + scale * self.ball @ rotation.T))
        arrow = arrow_line(np.zeros(3), 0.35 * self.reach * rotation[:, 1], _view(self.close_up))
        self.device_moment.set_data_3d(*arrow.T)


def _view(axes: Axes3D) -> Floats:
    """Direction from the scene to the eye."""
    elevation, azimuth = np.radians([axes.elev, axes.azim])
    return np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
