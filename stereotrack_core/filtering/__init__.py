"""Unscented transform, correction, iteration, smoothing: no body in here."""
