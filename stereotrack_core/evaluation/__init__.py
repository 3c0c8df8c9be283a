"""Angular errors against a reference, tables and segments."""
