"""The language as Pydantic models, and their validation errors as diagnostics."""
