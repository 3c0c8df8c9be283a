"""The commands of ``stereotrack study``, one module each."""
