"""Scene documents as files that a person would keep: the layout of their YAML, and what makes them shorter."""
