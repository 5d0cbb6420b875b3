"""Proof of an origin: a file on it, fetched only from public HTTPS addresses."""
