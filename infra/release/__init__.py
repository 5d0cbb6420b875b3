"""Releases: a version in one place, a changelog entry, a tag, and artifacts of a clean checkout."""
