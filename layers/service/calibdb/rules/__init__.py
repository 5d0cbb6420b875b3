"""Rules of sessions, checks and votes, on their documents alone."""
