"""Proof of an origin: a file on it, fetched from public HTTPS addresses alone."""
