"""A capsule from an STL file: its resistance by the boundary model, and a run of it under the magnet."""

import numpy as np
import trimesh

import helimag as hm

shape = trimesh.creation.capsule(height=4.0, radius=0.5, count=[8, 12])  # along z, in the file's own unit
shape.export("capsule.stl")

base = hm.load("paper/fig3c")
scenario = base.replaced(
    {
        "name": "capsule",
        "device.helix": None,
        "device.head": None,
        "device.body": {"file": "capsule.stl", "unit": "1 mm", "long_axis": (0, 0, 1), "moment_axis": (1, 0, 0)},
        "device.hydrodynamics.model": "boundary",
        "device.hydrodynamics.tolerance": 0.02,
        "run.duration": "5 s",
    }
)
matrix = hm.resistance(scenario.device, scenario.fluid)
along, across = matrix[0, 0], matrix[1, 1]
print(f"drag along {along:.4f}, across {across:.4f} N s/m; coupling {matrix[0, 3]:.1e} N s")
run = hm.simulate(scenario)
print(f"after 5 s at {1e3 * run.final_state[2]:.3f} mm")

# an egg of the same length and width lies inside, a ball around it outside: the drag is between theirs
egg = {"shape": "spheroid", "length": "5 mm", "diameter": "1 mm"}
inside = hm.resistance(scenario.replaced({"device.body": None, "device.head": egg}).device, scenario.fluid)[0, 0]
outside = 6.0 * np.pi * scenario.fluid.viscosity * 2.5e-3
assert inside < along < across < outside
assert abs(matrix[0, 3]) < 1e-3 * np.sqrt(along * matrix[3, 3])  # no screw: no thrust from spin
