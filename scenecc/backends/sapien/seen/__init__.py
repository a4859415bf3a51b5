"""Lights, surroundings and cameras: what is built for pictures alone, once the bodies stand."""
