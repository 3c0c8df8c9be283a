"""Sweep: many values of parameters at once."""
