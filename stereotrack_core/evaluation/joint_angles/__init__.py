"""Joint angles as a laboratory reports them, with velocities, ranges and uncertainty."""
