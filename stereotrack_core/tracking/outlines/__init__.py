"""Outlines of the body that must lie on the edges of the silhouettes (docs/method.md 4.11)."""
