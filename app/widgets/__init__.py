"""What is shown: widgets that know no session, service or feature."""
