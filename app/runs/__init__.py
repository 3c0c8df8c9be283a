"""Runs in the window: kept in the project, repeated, described."""
