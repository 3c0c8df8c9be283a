"""Inspect: what the tracker does within one frame."""
