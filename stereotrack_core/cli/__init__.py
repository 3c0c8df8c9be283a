"""The command line: one module per command, each thin over a function of the core."""

from stereotrack_core.cli.program import main

__all__ = ["main"]
