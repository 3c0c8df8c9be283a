"""Tune: attempts beside a run, and presets."""
