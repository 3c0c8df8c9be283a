"""Recordings x settings x seeds: one description, one store, one runner, one table.

``description`` says what is tracked, ``plan`` makes jobs of it, ``workers`` do them, ``store``
keeps their results and ``run`` brings these together. A sweep is a study whose recordings and
settings come from the command line, and whose runs are not kept.
"""
