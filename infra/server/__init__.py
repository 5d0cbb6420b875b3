"""The self-hosted server: one process, or several, over one SQLite file."""
