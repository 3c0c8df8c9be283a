"""Outlines of the body that must lie on the edges of the silhouettes (method.md 4L)."""
