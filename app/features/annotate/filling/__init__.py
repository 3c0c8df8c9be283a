"""Fits and predictions that fill in what nobody clicked."""
