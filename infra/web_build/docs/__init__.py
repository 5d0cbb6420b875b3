"""Pages under `/docs/`, built from the project's Markdown, `web/openapi.json` and the package's integrity."""
