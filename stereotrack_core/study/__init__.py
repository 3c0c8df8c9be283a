"""Recordings x settings x seeds: one description, one store, one runner, one table.

A sweep is a study of recordings and settings from the command line, whose runs are not kept.
"""
