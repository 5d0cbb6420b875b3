"""HTTP: calls parsed, media types negotiated, answers and problems sent, metrics counted."""
