"""Rules over a plan and its assets: one function per rule, one file per family."""
