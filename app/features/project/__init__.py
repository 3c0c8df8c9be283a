"""Recordings, projects and their files."""
