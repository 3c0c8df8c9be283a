"""Calibrations of other tools: one file per format, and how an open convention is decided."""
