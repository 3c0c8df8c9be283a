"""Subjects and sets of landmarks."""
