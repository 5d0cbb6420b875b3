"""Build steps of the web client: OpenAPI document, vendored packages, precache manifest, plan."""
