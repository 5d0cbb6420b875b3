"""Rules of sessions, checks and votes: pure functions of their documents."""
