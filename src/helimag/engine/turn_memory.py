"""What is remembered of turns that were followed, and what turns between them looked like.

A turn's shape is what it does beside going straight from its start to its end. It repeats itself almost from turn to
turn, so that the shapes of turns that were leapt over are interpolated, by the leap's own polynomial, at equally spaced
nodes. Heights between nodes are those of the trigonometric polynomial through them.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.charts import Place, to_chart
from helimag.engine.lanes import LANES
from helimag.engine.structures import reader
from helimag.engine.turns import NODES, Nodes, Shape, rolled
from helimag.physics.balance import SHEETS, Sheet
from helimag.physics.kinematics import State, attack_angle, normalized

MOST_TURNS = 100  # of a leap
SLOTS = 10  # turns remembered: as many as a polynomial goes through, and the one at the leap's end, in a ring
FINE = 2  # heights are looked at so many times between two nodes, and parabolas put through three looks
LOOKS = wp.constant(FINE * NODES)
COUNT = wp.constant(wp.float64(NODES))
ONE = wp.constant(wp.float64(1.0))
ZERO = wp.constant(wp.float64(0.0))
AT_NODE = wp.constant(wp.float64(1e-9))  # of a turn: nearer than this is at the node

Square = wp.types.matrix(shape=(6, 6), dtype=wp.float64)
Weights = wp.types.vector(length=SLOTS, dtype=wp.float64)
Heights = wp.types.vector(length=FINE * NODES, dtype=wp.float64)
Finer = wp.types.matrix(shape=(FINE * NODES, NODES), dtype=wp.float64)


def _cardinal(away: np.ndarray) -> np.ndarray:
    """Trigonometric polynomial that is 1 at a node and 0 at all others, by the distance from it in turns."""
    away = away - np.round(away)
    safe = np.where(np.abs(away) < float(AT_NODE), 0.25, away)
    return np.where(np.abs(away) < float(AT_NODE), 1.0, np.sin(NODES * np.pi * safe) / (NODES * np.tan(np.pi * safe)))


LOOK_PHASES = np.arange(1, FINE * NODES + 1) / (FINE * NODES)
NODE_PHASES = np.arange(1, NODES + 1) / NODES
FINER = wp.constant(Finer(*_cardinal(LOOK_PHASES[:, None] - NODE_PHASES).ravel().tolist()))


@wp.struct
class Memory:
    """Turns that were followed, of all runs, each in one of SLOTS slots; moving frame."""

    numbers: wp.array2d(dtype=wp.float64)  # of the turn, from where leaping began
    places: wp.array2d(dtype=State)  # where it began
    ends: wp.array2d(dtype=State)  # where it ended
    nodes: wp.array3d(dtype=State)  # (runs, SLOTS, NODES), the last of which is the end
    heights: wp.array2d(dtype=Heights)  # FINE times as fine, m
    attacks: wp.array2d(dtype=Nodes)  # attack angle, rad
    jacobians: wp.array(dtype=Square)  # (runs,): how what a turn changes depends on where it begins, in a chart
    begins: wp.array2d(dtype=Place)  # where it began, in that chart
    residuals: wp.array2d(dtype=Place)  # what it changed, but for what the Jacobian has of that
    path: wp.array2d(dtype=State)  # (runs, MOST_TURNS): where turns of the leap that is tried end
    seen: wp.array2d(dtype=State)  # (runs, LANES): samples of a leap, lab frame
    looks: wp.array3d(dtype=Sheet)  # (runs, NODES, SHEETS): what was around it in the turn followed last
    weights: wp.array2d(dtype=Weights)  # (runs, MOST_TURNS): what each slot counts in each of them


ROOMS: dict[str, tuple[Any, ...]] = {  # of one run: kind and shape
    "numbers": (wp.float64, SLOTS),
    "places": (State, SLOTS),
    "ends": (State, SLOTS),
    "nodes": (State, SLOTS, NODES),
    "heights": (Heights, SLOTS),
    "attacks": (Nodes, SLOTS),
    "jacobians": (Square,),
    "begins": (Place, SLOTS),
    "residuals": (Place, SLOTS),
    "path": (State, MOST_TURNS),
    "weights": (Weights, MOST_TURNS),
    "seen": (State, LANES),
}


def pack_memory(remembered: Sequence[dict[str, NDArray[np.float64]]], device: str, *, looks: bool = False) -> Any:
    """What runs remember of turns, as the kernels take it; a run that remembers nothing has room for it.

    ``looks``: whether what was around the device is remembered too, which in open water is the same everywhere.
    """
    memory = Memory()
    runs = len(remembered)
    for name, (kind, *shape) in (ROOMS | {"looks": (Sheet, NODES * looks, int(SHEETS))}).items():
        setattr(memory, name, wp.zeros((runs, *shape), dtype=kind, device=device))
    for run, known in enumerate(remembered):
        for name, values in known.items():
            getattr(memory, name)[run : run + 1].assign(values[None])
    return memory


def memory_reader(memory: Any) -> Callable[[NDArray[np.bool_]], list[dict[str, NDArray[np.float64]]]]:
    """What gives what each run remembers at the time it is called: nothing where it will not go on."""
    names = [*ROOMS, "looks"] if memory.looks.size else [*ROOMS]
    readers = {name: reader(getattr(memory, name)) for name in names}

    def remembered(running: NDArray[np.bool_]) -> list[dict[str, NDArray[np.float64]]]:
        values = {name: read() for name, read in readers.items()} if running.any() else {}
        return [
            {name: value[run].copy() for name, value in values.items()} if goes_on else {}
            for run, goes_on in enumerate(running.tolist())
        ]

    return remembered


@wp.func
def slot_of(push: int) -> int:
    """Where the turn remembered as number ``push`` is kept."""
    return push % SLOTS


@wp.func
def store_shape(memory: Memory, run: int, slot: int, shape: Shape, begin: State, end: State):
    """Keep what a turn was beside straight: at nodes ``shape``, from ``begin`` to ``end``."""
    attacks = Nodes()
    heights = Nodes()
    first = attack_angle(begin)
    climb = attack_angle(end) - first
    for j in range(NODES):
        share = wp.float64(j + 1) / COUNT
        at = State()
        for c in range(7):
            at[c] = shape[j, c]
        rest = at - begin - share * (end - begin)
        memory.nodes[run, slot, j] = rest
        attacks[j] = attack_angle(at) - first - share * climb
        heights[j] = rest[2]
    memory.attacks[run, slot] = attacks
    memory.heights[run, slot] = FINER * heights


@wp.func
def chart_turn(memory: Memory, run: int, slot: int, reference: State, miss: Place):
    """Work out what a remembered turn is in the chart, and beside the Jacobian; less what its steps missed."""
    begin = to_chart(reference, memory.places[run, slot])
    change = to_chart(reference, memory.ends[run, slot]) - begin
    memory.begins[run, slot] = begin
    memory.residuals[run, slot] = change - memory.jacobians[run] * begin + miss


@wp.func
def heights_between(memory: Memory, run: int, weights: Weights) -> Heights:
    """Heights of a turn beside straight, from turns remembered, by what each slot counts (m)."""
    total = Heights()
    for slot in range(SLOTS):
        total += weights[slot] * memory.heights[run, slot]
    return total


@wp.func
def attacks_between(memory: Memory, run: int, weights: Weights) -> Nodes:
    """Attack angles of a turn beside straight, likewise (rad)."""
    total = Nodes()
    for slot in range(SLOTS):
        total += weights[slot] * memory.attacks[run, slot]
    return total


@wp.func
def node_between(memory: Memory, run: int, weights: Weights, node: int, begin: State, end: State) -> State:
    """The state at a node of a turn from ``begin`` to ``end``, likewise; the turn's own roll off, see :class:`Turn`."""
    state = begin + (wp.float64(node) / COUNT) * (end - begin)
    for slot in range(SLOTS):
        state += weights[slot] * memory.nodes[run, slot, node - 1]
    return normalized(state)


@wp.func
def after_turns(state: State, number: wp.float64) -> State:
    """The state after the body rolled a whole ``number`` of turns: each changes the sign of its quaternion."""
    half = wp.float64(0.5) * number
    sign = wp.where(half == wp.floor(half), ONE, -ONE)
    return rolled(state, sign, ZERO)
