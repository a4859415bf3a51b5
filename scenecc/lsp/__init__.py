"""The language server: what editors show of a scene file while it is typed."""
