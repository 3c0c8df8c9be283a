"""Movement for other programs: OpenSim, movement and Rerun."""
