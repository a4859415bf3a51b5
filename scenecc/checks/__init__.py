"""Rules over a plan and its assets: one rule a function, one file a family."""
