"""Annotation in the window: its panels and dialogs around an open project."""
