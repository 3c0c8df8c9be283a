"""Checks of a recording's cameras, pairs and clocks by its images and depths."""
