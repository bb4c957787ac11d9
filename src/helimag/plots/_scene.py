"""The scene of a film: what stands still is drawn once, what moves anew for each frame."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from helimag.geometry import body_rotations
from helimag.plots._path import extent, frame_box
from helimag.plots._quantities import Shown, shown
from helimag.plots._series import draw_height
from helimag.plots._shapes import arrow_line, axis_rotation, cylinder_faces, head_faces, helix_line
from helimag.plots._style import BLUE, GREEN, GREY, ORANGE, PALE, PURPLE, SKY, VERMILLION
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Device, Magnet

Floats = NDArray[np.float64]

WIDTH, HEIGHT = 1280, 720  # dots
DOTS_PER_INCH = 100
DEVICE_SHARE = 0.12  # of the scene's size: the device is enlarged to about this
FILM: Any = {
    "font.size": 10.0,
    "axes.labelsize": 10.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "lines.linewidth": 1.6,
}


def enlargement(run: Shown) -> int:
    """How many times its size the device is drawn in the whole scene, where it would be too small to see."""
    if run.scenario is None:
        return 1
    return max(1, round(DEVICE_SHARE * _size(run) / _length(run.scenario.device)))


def _size(run: Shown) -> float:
    low, high = extent(run)
    return float((high - low).max())


def _length(device: Device) -> float:
    """From end to end (mm)."""
    return 1e3 * device.length


class Scene:
    """Draws single samples of a run. Make it, and use it, within the style.

    Parameters
    ----------
    trajectory
        The run. What it does not hold is left out: the device needs its scenario and quaternions, the magnet its
        scenario and moments.
    remark
        Written at the foot of every frame.
    """

    def __init__(self, trajectory: Trajectory, remark: str) -> None:
        self.run = shown(trajectory)
        self.data = {str(name): np.asarray(values.values) for name, values in trajectory.dataset.data_vars.items()}
        self.figure = Figure(figsize=(WIDTH / DOTS_PER_INCH, HEIGHT / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
        self.canvas = FigureCanvasAgg(self.figure)
        self.moving: list[tuple[Axes, Any]] = []
        self.places: list[Callable[[int], None]] = []
        self.whole = self._stage(remark)
        self._cast_path()
        self._cast_height()
        scenario = self.run.scenario
        if scenario is not None and self.run.magnet is not None and "rpm_moment" in self.data:
            self._cast_magnet(scenario.magnet[0], self.run.magnet)
        if scenario is not None and "quaternion" in self.data:
            self._cast_close_up(scenario.device)
            self._cast_device(self.whole, scenario.device, self.run.position, scale=enlargement(self.run), width=2.0)
        if "field" in self.data:
            self._cast_arrow(self.whole, self.run.position, self._unit("field"), 0.16 * _size(self.run), GREEN)
        self.canvas.draw()  # type: ignore[no-untyped-call]
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)  # type: ignore[no-untyped-call]

    def frame(self, sample: int) -> NDArray[np.uint8]:
        """Draw one sample: (height, width, 3) red, green, blue."""
        for place in self.places:
            place(sample)
        self.canvas.restore_region(self.background)  # type: ignore[no-untyped-call]
        for axes, artist in self.moving:
            if isinstance(artist, Poly3DCollection):
                artist.do_3d_projection()
            axes.draw_artist(artist)
        picture = np.asarray(self.canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        return picture[:, :, :3].copy()

    def _stage(self, remark: str) -> Axes3D:
        """Words, and the box with the magnet's path."""
        self.figure.text(0.02, 0.965, self.run.name, weight="bold", fontsize=14, va="top")
        self.figure.text(0.02, 0.92, self.run.verdict, fontsize=10.5, va="top")
        self.figure.text(0.02, 0.02, remark, fontsize=9, color="#555555", linespacing=1.4)
        axes: Axes3D = self.figure.add_axes((0.0, 0.11, 0.55, 0.73), projection="3d")
        frame_box(axes, *extent(self.run, around_magnet=self._room()))
        if self.run.magnet is not None:
            axes.plot(*self.run.magnet.T, color=PALE, linewidth=1.2)
        return axes

    def _room(self) -> float:
        """Around the magnet's centre, for it to turn in with its arrow (mm)."""
        return 0.0 if self.run.scenario is None else 1.5e3 * self.run.scenario.magnet[0].reach

    def _cast_path(self) -> None:
        """The head, its path so far, and what the time is."""
        run = self.run
        clock = self._move(self.whole, self.figure.text(0.02, 0.875, "", fontsize=12, va="top", family="monospace"))
        path = self._line(self.whole, BLUE, 1.4)
        head = self._move(self.whole, self.whole.plot([], [], [], "o", color=BLUE, markersize=4)[0])
        strength = 1e3 * np.linalg.norm(self.data["field"], axis=1) if "field" in self.data else None

        def place(sample: int) -> None:
            words = f"t = {run.time[sample]:7.1f} s   z = {run.position[sample, 2]:7.1f} mm"
            clock.set_text(words if strength is None else f"{words}   field {strength[sample]:6.2f} mT")
            path.set_data_3d(*run.position[: sample + 1].T)
            head.set_data_3d(*run.position[sample, :, None])

        self.places.append(place)

    def _cast_height(self) -> None:
        """Height over time, with the part that is still to come pale."""
        run = self.run
        axes = self.figure.add_axes((0.65, 0.14, 0.28, 0.24))
        draw_height(axes, run)
        axes.lines[0].set(color=SKY, linewidth=0.8)
        axes.set(xlim=(run.time[0], max(run.time[-1], run.time[0] + 1e-9)), xlabel="time (s)")
        so_far = self._move(axes, axes.plot([], [], color=BLUE)[0])
        now = self._move(axes, axes.plot([], [], "o", color=BLUE, markersize=5)[0])

        def place(sample: int) -> None:
            so_far.set_data(run.time[: sample + 1], run.position[: sample + 1, 2])
            now.set_data([run.time[sample]], [run.position[sample, 2]])

        self.places.append(place)

    def _cast_magnet(self, magnet: Magnet, centres: Floats) -> None:
        """A cylinder with a vermillion north half and a blue south half, and its moment."""
        faces, north = cylinder_faces(magnet)
        points = 1e3 * np.concatenate(faces)
        splits = np.cumsum([len(face) for face in faces])[:-1]
        directions = self._unit("rpm_moment")
        solid = self._solid(self.whole, [VERMILLION if upper else BLUE for upper in north])
        self.places.append(
            lambda i: solid.set_verts(np.split(centres[i] + points @ axis_rotation(directions[i]).T, splits))
        )
        self._cast_arrow(self.whole, centres, directions, self._room(), "black")

    def _cast_close_up(self, device: Device) -> None:
        """The device to scale, its moment, and the field."""
        reach = 1.05 * _length(device)
        axes: Axes3D = self.figure.add_axes((0.58, 0.38, 0.42, 0.48), projection="3d")
        frame_box(axes, np.full(3, -reach), np.full(3, reach))
        axes.set(xlabel="", ylabel="", zlabel="")
        self.figure.text(0.6, 0.875, "device, to scale (mm from its head)", fontsize=10)
        self.figure.text(0.6, 0.845, "device's moment", fontsize=10, color=PURPLE, weight="bold")
        centres = np.zeros_like(self.run.position)
        self._cast_device(axes, device, centres, scale=1, width=4.5)
        moments = body_rotations(self.data["quaternion"])[..., 1]
        self._cast_arrow(axes, centres, moments, 0.35 * reach, PURPLE)
        if "field" in self.data:
            self.figure.text(0.72, 0.845, "field", fontsize=10, color=GREEN, weight="bold")
            self._cast_arrow(axes, centres, self._unit("field"), 0.9 * reach, GREEN)

    def _cast_device(self, axes: Axes3D, device: Device, centres: Floats, *, scale: int, width: float) -> None:
        """Helix and head."""
        points = 1e3 * scale * helix_line(device)
        surface = [1e3 * scale * face for face in head_faces(device)]
        helix = self._line(axes, ORANGE, width)
        head = self._solid(axes, GREY)

        def place(sample: int) -> None:
            turn = body_rotations(self.data["quaternion"][sample]).T
            helix.set_data_3d(*(centres[sample] + points @ turn).T)
            head.set_verts([centres[sample] + face @ turn for face in surface])

        self.places.append(place)

    def _cast_arrow(self, axes: Axes3D, tails: Floats, directions: Floats, length: float, colour: str) -> None:
        line = self._line(axes, colour, 2.2)
        eye = _view(axes)
        self.places.append(lambda i: line.set_data_3d(*arrow_line(tails[i], length * directions[i], eye).T))

    def _unit(self, name: str) -> Floats:
        """A vector over time, of unit length; zero where it is zero."""
        vectors = self.data[name]
        lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
        unit: Floats = np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)
        return unit

    def _line(self, axes: Axes3D, colour: str, width: float) -> Any:
        return self._move(
            axes, axes.plot([], [], [], color=colour, linewidth=width, solid_capstyle="round", clip_on=False)[0]
        )

    def _solid(self, axes: Axes3D, colours: Any) -> Poly3DCollection:
        solid = Poly3DCollection(
            [np.zeros((3, 3))], facecolors=colours, edgecolors="#00000030", linewidths=0.3, clip_on=False
        )
        axes.add_collection3d(solid, autolim=False)
        self._move(axes, solid)
        return solid

    def _move(self, axes: Axes, artist: Any) -> Any:
        """Take an artist out of the still background; those that move are drawn in the order they come in here."""
        artist.set_animated(True)
        self.moving.append((axes, artist))
        return artist


def _view(axes: Axes3D) -> Floats:
    """Direction from the scene to the eye."""
    elevation, azimuth = np.radians([axes.elev, axes.azim])
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
