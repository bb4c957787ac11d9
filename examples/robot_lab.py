"""A programme for a laboratory: handshake with the motor, load, spline motions, and the way up at the end."""

import helimag as hm
from helimag import robot
from helimag.robot.arm import Load, Motor

motor = Motor(run_output=5, speed_input=7, phase_input=8)
load = Load(mass=1.2, center=(0.0, 0.0, 0.08), inertia=(0.004, 0.004, 0.001))
cell = robot.load_cell("wide").model_copy(update={"motor": motor, "load": load, "retreat": 0.1})
scenario = hm.load("paper/fig3c").replaced({"run.duration": "150 s"})
lap = robot.plan(scenario, cell)
src, dat = robot.write_krl(lap, "lap", spline=True)
shown = ("$OUT", "WAIT", "SPLINE", "  SCIRC", "INTERRUPT")
print("\n".join(line for line in src.splitlines() if line.startswith(shown)))

playback = robot.play(src, dat, cell.arm, inputs=cell.inputs)
found = robot.deviation(lap, playback)
print(f"read back: {1e6 * found.position:.3f} um, {found.axis:.1e} rad, {100 * found.timing:.4f} % of the time")
top = playback.tool(cell)[-1, 2, 3] - playback.tool(cell)[0, 2, 3]
print(f"at the end the magnet is {1e3 * top:.1f} mm above the circle")

# what was written is the plan, with all that the motor is told, and off when the arm is stopped
assert lap.feasible
assert found.acceptable
assert [(each.input, each.on) for each in playback.awaited] == [(7, True), (8, False), (8, True)]
assert [(each.output, each.on) for each in playback.switches] == [(5, True), (5, False)]
assert playback.on_stop == ((5, False),)
assert abs(top - 0.1) < 1e-6
# without the wait for the motor it is another programme
assert not robot.deviation(lap, robot.play(src.replace("WAIT FOR $IN[7]\n", ""), dat, cell.arm, inputs={8})).acceptable
