"""Tune: trials beside a run, and presets."""
