"""The server for agents (Model Context Protocol): tools that run commands of scenecc and return their JSON."""
