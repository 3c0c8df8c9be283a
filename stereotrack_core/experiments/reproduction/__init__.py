"""The thesis's evaluation, repeated: its tables and curves beside ours."""
