"""Movement for other programs: OpenSim, movement, Blender and Rerun."""
