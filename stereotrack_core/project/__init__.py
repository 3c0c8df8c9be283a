"""The project file: clicks, history, references, runs and settings of a recording."""
