"""Shared code of all functions: schema, errors, HTTP, access, camera keys, rules, storage, lookup.

Contains no geometry and imports neither numpy nor OpenCV. Results of the solver pass through as the pydantic
models of `calibdb.schema`.
"""

#: version of the whole project, and its only place
__version__ = "0.1.0"
