"""Correspondences, residuals, the tracker's step, presets, and the pipeline around them."""
