"""Dialogs of sweeps: what is tried, how it is going, and what came of it."""
