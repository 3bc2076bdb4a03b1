"""`bldsimp batch` on a cluster of Dask's: a scheduler and two workers, as processes of this machine."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from batch_runs import (
    list_done,
    list_failed,
    make_misbehaving,
    read_results,
    read_rows,
    run_batch,
    start_batch,
    wait_for_rows,
    write_buildings,
)
from shapes import write

distributed = pytest.importorskip("distributed", reason="Dask is not installed: bldsimp[dask]")

SMALL_GROUPS = """
import bldsimp.batch.dask as pool
pool.GROUP_FILES = 5
pool.CONNECT_SECONDS = 2
"""


class Cluster:
    """A scheduler and its workers."""

    def __init__(self, folder: Path, environment: dict[str, str], *, nannies: bool = False) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.folder = folder
        self.environment = environment
        self.processes = [self._start("scheduler", "--host", "127.0.0.1", "--port", str(self.port))]
        for _ in range(2):
            self.processes.append(
                self._start("worker", self.address, "--nthreads", "1", "--nanny" if nannies else "--no-nanny")
            )

    def _start(self, kind: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words, "--no-dashboard"]
        with open(self.folder / f"{kind}.log", "ab") as log:
            return subprocess.Popen(
                command, cwd=self.folder, env=self.environment, stdout=log, stderr=log, start_new_session=True
            )

    def kill(self, which: int) -> None:
        """Kill a process, with its children."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.processes[which].pid, signal.SIGKILL)
        self.processes[which].wait()

    def stop(self) -> None:
        for i in range(len(self.processes)):
            self.kill(i)


@pytest.fixture
def clusters(tmp_path: Path) -> Iterator[list[Cluster]]:
    """Clusters that a test starts, and that end with it."""
    started: list[Cluster] = []
    yield started
    for cluster in started:
        cluster.stop()


def test_a_cluster_writes_the_results_of_one_machine(tmp_path: Path, clusters: list[Cluster]) -> None:
    models = write_buildings(tmp_path / "models", 6)
    # Under a nanny, Dask's default, `multiprocessing` may start no process.
    clusters.append(Cluster(tmp_path, dict(os.environ), nannies=True))
    assert run_batch(models, tmp_path / "out", "--scheduler", clusters[0].address).returncode == 0
    assert run_batch(models, tmp_path / "whole").returncode == 0
    assert read_results(tmp_path / "out") == read_results(tmp_path / "whole")


@pytest.mark.slow
@pytest.mark.parametrize("deaths", ["0", "3"])
def test_a_worker_dies_then_the_scheduler_and_a_resumed_run_finishes(
    deaths: str, tmp_path: Path, clusters: list[Cluster]
) -> None:
    """Whether Dask itself gives a group to another worker after so many deaths, or gives it back."""
    models, out, whole = write_buildings(tmp_path / "models", 60), tmp_path / "out", tmp_path / "whole"
    slow = make_misbehaving(tmp_path / "site", SMALL_GROUPS, SECONDS_PER_FILE="0.1")
    first = Cluster(tmp_path, slow | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": deaths})
    clusters.append(first)
    with start_batch(models, out, "--scheduler", first.address, env=slow) as process:
        wait_for_rows(out / "manifest.jsonl", 5, process)
        first.kill(1)
        wait_for_rows(out / "manifest.jsonl", 15, process)
        first.kill(0)
        stderr = process.communicate()[1].decode()
    assert process.returncode == 1
    assert "the scheduler is gone" in stderr.splitlines()[-1]
    recorded = read_rows(out / "manifest.jsonl")
    assert 15 <= len(recorded) < 60
    times = {row["output"]: os.stat(out / row["output"]).st_mtime_ns for row in recorded}

    second = Cluster(tmp_path, slow | {"SECONDS_PER_FILE": "0"})
    clusters.append(second)
    assert run_batch(models, out, "--scheduler", second.address, "--resume", env=slow).returncode == 0
    assert read_rows(out / "manifest.jsonl")[: len(recorded)] == recorded
    names = list_done(out / "manifest.jsonl")
    assert len(names) == len(set(names)) == 60
    assert times == {name: os.stat(out / name).st_mtime_ns for name in times}
    assert run_batch(models, whole).returncode == 0
    assert read_results(out) == read_results(whole)


@pytest.mark.slow
def test_bad_files_cost_no_other(tmp_path: Path, clusters: list[Cluster]) -> None:
    models, out = write_buildings(tmp_path / "models", 12), tmp_path / "out"
    for name in ("hangs", "crashes", "grows"):
        write(models / f"{name}.obj", (models / "district 0" / "building_000.obj").read_bytes())
    write(models / "bad.obj", "no model")
    environment = make_misbehaving(tmp_path / "site", SMALL_GROUPS)
    cluster = Cluster(tmp_path, environment)
    clusters.append(cluster)
    words = ("--scheduler", cluster.address, "--timeout", "2", "--memory", "300M")
    assert run_batch(models, out, *words, env=environment).returncode == 1
    assert {name: (row["kind"], row["attempts"]) for name, row in list_failed(out / "manifest.jsonl").items()} == {
        "hangs.obj": ("timeout", 2), "crashes.obj": ("crash", 2), "grows.obj": ("memory", 2), "bad.obj": ("input", 2),
    }  # fmt: skip
    assert len(list_done(out / "manifest.jsonl")) == len(read_results(out)) == 12


def test_a_scheduler_that_does_not_answer(tmp_path: Path) -> None:
    models = write_buildings(tmp_path / "models", 1)
    environment = make_misbehaving(tmp_path / "site", SMALL_GROUPS)
    result = run_batch(models, tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9", env=environment)
    assert result.returncode == 1
    assert "does not answer" in result.stderr.decode().splitlines()[-1]
