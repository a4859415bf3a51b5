"""Builds plans: one folder for each engine, loaded when a scene is built. They do not depend on the language."""
