"""`python -m scenecc` runs `scenecc`."""

from scenecc.cli import main

if __name__ == "__main__":
    main()
