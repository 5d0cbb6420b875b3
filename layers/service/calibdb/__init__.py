"""What every function of calibDB shares: schema, errors, HTTP, tokens, camera keys, store.

Knows nothing of geometry: neither numpy nor OpenCV is imported from here, and what the solver makes
passes through as the pydantic models of `calibdb.schema`.
"""

__version__ = "0.1.0"
