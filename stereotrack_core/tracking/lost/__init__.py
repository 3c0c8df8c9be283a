"""Whether a limb is lost, said without truth (docs/method.md 4.14)."""
