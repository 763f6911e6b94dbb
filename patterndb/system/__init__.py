"""What touches the machine: caches (the user's folder), mappedarrays (arrays kept there), files,
documents (JSON), and readers of formats that are no
one tool's own."""
