"""Pages that stand alone: HTML with embedded pictures, for a browser and for printing."""
