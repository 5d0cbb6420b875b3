"""Pages under `/docs/`, built from Markdown, the OpenAPI document and the SDK's integrity."""
