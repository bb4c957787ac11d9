"""Parts of the page, each in a file: inputs, verdict, scene, charts, map, compare, robot, explain, ensemble."""
