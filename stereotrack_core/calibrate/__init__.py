"""From pictures of a board to calibrated cameras, and their world turned upright."""
