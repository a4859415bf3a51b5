"""Videos read back, by ffmpeg itself."""

from __future__ import annotations

import re
import subprocess
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np


def decoded(video: Path) -> tuple[float, list[np.ndarray[Any, Any]]]:
    """Frames a second, and the frames (H, W, 3) uint8."""
    program = import_module("imageio_ffmpeg").get_ffmpeg_exe()
    command = [program, "-i", str(video), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True, timeout=60)
    said = done.stderr.decode()
    stream = re.search(r"Video: .*?, (\d+)x(\d+)[ ,].*?([\d.]+) fps", said)
    assert stream is not None, said
    width, height, rate = int(stream[1]), int(stream[2]), float(stream[3])
    return rate, list(np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3))
