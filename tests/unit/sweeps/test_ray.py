"""Sweeps on Ray: a cluster of one node, and one of two, of which a worker and then a node are killed."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import scenecc

pytest.importorskip("ray")

SCENE = """\
scenecc: 1
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [{uniform: [-0.1, 0.1]}, 0, 0.1], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""

SCRIPT = """\
import json, os, sys
from pathlib import Path

import ray
from ray.cluster_utils import Cluster

import scenecc

head = {"num_cpus": 1, "include_dashboard": False}
cluster = Cluster(initialize_head=True, head_node_args=head)
node = cluster.add_node(num_cpus=1)
killed = []


def kill(done, total):
    if done == 4:
        line = json.loads(Path("swept/log.jsonl").read_text().splitlines()[-1])
        killed.append(int(line["worker"].rpartition(":")[2]))
        os.kill(killed[0], 9)
    if done == 12:
        cluster.remove_node(node, allow_graceful=False)
        killed.append(node)


result = scenecc.sweep(
    "scene.yaml", seeds=range(40), settle=0.5, output="swept", ray_address=cluster.address, progress=kill
)
assert len(killed) == 2 and not ray.is_initialized()


def remove(done, total):
    Path("scene.yaml").unlink(missing_ok=True)


try:
    scenecc.sweep("scene.yaml", seeds=range(40), output="removed", ray_address=cluster.address, progress=remove)
except scenecc.SceneError as error:
    (found,) = error.diagnostics
    assert found.code == "SC829" and "scene.yaml` does not exist" in found.message and "on " in found.message
else:
    raise AssertionError
cluster.shutdown()
"""


def run_script(script: str) -> None:
    """Runs a script in a process of its own: Ray's threads would stay in this one, which other tests fork."""
    environment = {**os.environ, "RAY_USAGE_STATS_ENABLED": "0"}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script], check=False, capture_output=True, env=environment, timeout=100
    )
    assert done.returncode == 0, done.stderr.decode()


def test_a_cluster_of_one_node_gives_the_same_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(SCENE)
    alone = scenecc.sweep("scene.yaml", seeds=range(2), settle=0.1, output="alone")
    run_script("import scenecc; scenecc.sweep('scene.yaml', seeds=range(2), settle=0.1, output='swept', ray=True)")
    assert alone.table is not None
    assert Path("swept/table.parquet").read_bytes() == alone.table.read_bytes()


def test_an_address_without_a_cluster_is_refused_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(SCENE)

    def answer() -> None:
        with server.accept()[0] as connection:
            connection.sendall(b"HTTP/1.0 400 Bad Request\r\n\r\n")

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answer).start()
        port = server.getsockname()[1]
        with pytest.raises(scenecc.SceneError, match="is not a Ray cluster"):
            scenecc.sweep("scene.yaml", output="swept", ray_address=f"127.0.0.1:{port}")
    for address in (f"127.0.0.1:{port}", "auto", "127.0.0.1:99999", ""):
        with pytest.raises(scenecc.SceneError, match="no Ray cluster answers"):
            scenecc.sweep("scene.yaml", output="swept", ray_address=address)


def test_the_table_is_the_same_if_a_worker_and_a_node_are_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(SCENE)
    alone = scenecc.sweep("scene.yaml", seeds=range(40), settle=0.5, output="alone")
    run_script(SCRIPT)
    assert alone.table is not None
    assert Path("swept/table.parquet").read_bytes() == alone.table.read_bytes()
    log = [json.loads(line) for line in Path("swept/log.jsonl").read_text().splitlines()]
    died = [line for line in log if "died" in line]
    assert {"WorkerCrashedError"} <= {line["died"] for line in died}
    last = dict(sorted((line["seed"], line["attempt"]) for line in died))
    attempts = {line["seed"]: line["attempt"] for line in log if "died" not in line}
    assert attempts == {seed: last.get(seed, 0) + 1 for seed in range(40)}
    assert len({line["worker"] for line in log if "worker" in line}) >= 2
