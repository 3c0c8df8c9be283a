"""Calibrate: the cameras, and what looks wrong about them."""
