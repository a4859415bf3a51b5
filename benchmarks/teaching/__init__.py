"""How well the compiler teaches: seeded faults in shipped scenes, and what it says of each."""
