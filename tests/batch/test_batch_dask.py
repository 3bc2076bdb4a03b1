"""`bldsimp batch` on a cluster of Dask's: a scheduler and two workers, as processes of this machine."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from batch_runs import buildings, done, failed, misbehaving, results, rows, run, start, wait_for_rows
from shapes import write

distributed = pytest.importorskip("distributed", reason="Dask is not installed: bldsimp[dask]")

SMALL_GROUPS = """
import bldsimp.batch.dask as pool
pool.GROUP_FILES = 5
pool.CONNECT_SECONDS = 2
"""


class Cluster:
    """A scheduler and its workers."""

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.folder = folder
        self.environment = environment
        self.processes = [self._start("scheduler", "--host", "127.0.0.1", "--port", str(self.port))]
        for _ in range(2):
            self.processes.append(self._start("worker", self.address, "--nthreads", "1", "--no-nanny"))

    def _start(self, kind: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words, "--no-dashboard"]
        with open(self.folder / f"{kind}.log", "ab") as log:
            return subprocess.Popen(
                command, cwd=self.folder, env=self.environment, stdout=log, stderr=log, start_new_session=True
            )

    def kill(self, which: int) -> None:
        self.processes[which].send_signal(signal.SIGKILL)
        self.processes[which].wait()

    def stop(self) -> None:
        for i in range(len(self.processes)):
            self.kill(i)


@pytest.fixture
def cluster_of(tmp_path: Path) -> Iterator[list[Cluster]]:
    """Clusters that a test starts, and that end with it."""
    started: list[Cluster] = []
    yield started
    for cluster in started:
        cluster.stop()


@pytest.mark.parametrize("deaths", ["0", "3"])
def test_a_worker_dies_then_the_scheduler_and_a_resumed_run_finishes(
    deaths: str, tmp_path: Path, cluster_of: list[Cluster]
) -> None:
    """Whether Dask itself gives a group to another worker after so many deaths, or gives it back."""
    models, light, whole = buildings(tmp_path / "models", 60), tmp_path / "light", tmp_path / "whole"
    slow = misbehaving(tmp_path / "site", SMALL_GROUPS, SECONDS_PER_FILE="0.1")
    first = Cluster(tmp_path, slow | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": deaths})
    cluster_of.append(first)
    with start(models, light, "--scheduler", first.address, env=slow) as process:
        wait_for_rows(light / "manifest.jsonl", 5, process)
        first.kill(1)
        wait_for_rows(light / "manifest.jsonl", 15, process)
        first.kill(0)
        stderr = process.communicate()[1].decode()
    assert process.returncode == 1
    assert "the scheduler is gone" in stderr.splitlines()[-1]
    recorded = rows(light / "manifest.jsonl")
    assert 15 <= len(recorded) < 60
    times = {row["output"]: os.stat(light / row["output"]).st_mtime_ns for row in recorded}

    second = Cluster(tmp_path, slow | {"SECONDS_PER_FILE": "0"})
    cluster_of.append(second)
    assert run(models, light, "--scheduler", second.address, "--resume", env=slow).returncode == 0
    assert rows(light / "manifest.jsonl")[: len(recorded)] == recorded
    names = done(light / "manifest.jsonl")
    assert len(names) == len(set(names)) == 60
    assert times == {name: os.stat(light / name).st_mtime_ns for name in times}
    assert run(models, whole).returncode == 0
    assert results(light) == results(whole)


def test_bad_files_cost_no_other(tmp_path: Path, cluster_of: list[Cluster]) -> None:
    models, light = buildings(tmp_path / "models", 12), tmp_path / "light"
    for name in ("hangs", "crashes", "grows"):
        write(models / f"{name}.obj", (models / "district 0" / "building_000.obj").read_bytes())
    write(models / "bad.obj", "no model")
    environment = misbehaving(tmp_path / "site", SMALL_GROUPS)
    cluster = Cluster(tmp_path, environment)
    cluster_of.append(cluster)
    words = ("--scheduler", cluster.address, "--timeout", "2", "--memory", "300M")
    assert run(models, light, *words, env=environment).returncode == 1
    assert {name: (row["kind"], row["attempts"]) for name, row in failed(light / "manifest.jsonl").items()} == {
        "hangs.obj": ("timeout", 2), "crashes.obj": ("crash", 2), "grows.obj": ("memory", 2), "bad.obj": ("input", 2),
    }  # fmt: skip
    assert len(done(light / "manifest.jsonl")) == len(results(light)) == 12


def test_a_scheduler_that_does_not_answer(tmp_path: Path) -> None:
    models = buildings(tmp_path / "models", 1)
    environment = misbehaving(tmp_path / "site", SMALL_GROUPS)
    result = run(models, tmp_path / "light", "--scheduler", "tcp://127.0.0.1:9", env=environment)
    assert result.returncode == 1
    assert "does not answer" in result.stderr.decode().splitlines()[-1]
