"""Trying parameters on a stretch: attempts, values of one parameter, presets of one's own."""
