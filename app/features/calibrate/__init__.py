"""Calibrate: the rig, and what looks wrong about it."""
