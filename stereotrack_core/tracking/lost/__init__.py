"""Whether a limb is lost, said without truth (method.md 4F)."""
