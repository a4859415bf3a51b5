"""What builds a plan: a folder an engine, loaded when a scene is built. They know nothing of the language."""
