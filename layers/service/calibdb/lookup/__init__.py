"""Lookup: camera identity, choice of a consensus, and its transfer to another size or zoom."""
