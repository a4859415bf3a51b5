"""`python -m scenecc` is `scenecc`."""

from scenecc.cli import main

if __name__ == "__main__":
    main()
