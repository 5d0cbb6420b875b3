"""Computations by the solver: documents in, documents out."""
