"""The arm: its kinematics, the cell around it, and a path planned and checked."""
