"""The language server: editor features for scene files while they are typed."""
