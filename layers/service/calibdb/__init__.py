"""Shared code of all functions: schema, errors, HTTP, access, camera keys, rules, storage, lookup.

Only `calibdb.compute` imports the solver.
"""

#: version of the whole project, and its only place
__version__ = "0.1.0"
