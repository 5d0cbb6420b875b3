"""HTTP: requests, content negotiation, responses, problem details, metrics."""
