"""Stretches in which a run fails."""
