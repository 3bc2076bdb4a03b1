"""Measure `bldsimp batch` with many small buildings: throughput, memory, kills, bad files, planning.

usage: python benchmarks/batch.py [--files N] [--sections NAME,...] [--folder FOLDER]
needs: pip install bldsimp[dask]; Linux

The buildings are made first (`many_buildings.py`), in FOLDER if one is given, where the next run finds them. Sections:
turns, memory, loop, dask, kills, poison, plan. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from many_buildings import make_buildings
from table import format_table

from bldsimp import Options
from bldsimp.batch.inputs import OutputLayout, find_inputs, plan_tasks
from bldsimp.batch.manifest import open_manifest, read_manifest
from bldsimp.batch.resume import collect_done, select_remaining
from bldsimp.batch.row import DONE, FileRow, make_row
from bldsimp.batch.task import Task
from bldsimp.cli import main as program

OURS = [sys.executable, "-c", "import sys; from bldsimp.cli import main; sys.exit(main())"]

WARM = """
import sys, time
from pathlib import Path
from bldsimp import _core
from bldsimp.job import simplify_file
from bldsimp.options import Options
_core.limit_threads(1)
paths = [Path(line) for line in sys.stdin.read().splitlines()]
out = Path(sys.argv[1])
simplify_file(paths[0], paths[0].suffix[1:], out / "first.glb", "glb", Options())
start, used = time.perf_counter(), time.process_time()
for i, path in enumerate(paths):
    simplify_file(path, path.suffix[1:], out / f"{i}.glb", "glb", Options())
print(time.perf_counter() - start, time.process_time() - used)
"""

SAMPLE = 1000
"""Files of the single warm process, in each of its runs."""

LOOP = 100
"""Files of the shell loop."""


def run_batch(*words: object, check: bool = True) -> subprocess.CompletedProcess[bytes]:
    """Run `bldsimp batch`."""
    return subprocess.run([*OURS, "batch", *map(str, words)], check=check, capture_output=True)


def choose_files(folder: Path, count: int) -> list[Path]:
    """Choose so many of the buildings at random."""
    return random.Random(1).sample(sorted(folder.rglob("building_*")), count)


@contextmanager
def make_scratch_folder() -> Iterator[Path]:
    """Make a folder for results."""
    with tempfile.TemporaryDirectory(prefix="bldsimp-") as folder:
        yield Path(folder)


def run_warm_processes(paths: list[Path], processes: int) -> tuple[float, float]:
    """Return files a second of warm processes side by side, and the processor seconds of a file."""
    with make_scratch_folder() as out:
        running = []
        for i in range(processes):
            (out / str(i)).mkdir()
            command = [sys.executable, "-c", WARM, str(out / str(i))]
            running.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
        told = []
        for i, process in enumerate(running):
            assert process.stdin is not None
            process.stdin.write("\n".join(map(str, paths[i::processes])))
            process.stdin.close()
        for process in running:
            assert process.stdout is not None
            told.append([float(word) for word in process.stdout.read().split()])
    return len(paths) / max(clock for clock, _ in told), sum(used for _, used in told) / len(paths)


def measure_resident(root: int) -> int:
    """Return the bytes that a process and its children have written to; memory that they share does not count."""
    parents = {}
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(entry.parent.name)] = int(entry.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
    family = {root}
    while more := {child for child, parent in parents.items() if parent in family} - family:
        family |= more
    total = 0
    for process in family:
        try:
            lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(line.split()[1]) * 1024 for line in lines if line.startswith("Anonymous:"))
    return total


def time_batch(words: Sequence[object], jobs: int) -> tuple[float, float]:
    """Return the seconds of a batch from start to end, of the clock and of the processors."""
    with make_scratch_folder() as out:
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        run_batch(*words, out / "out", "--to", "glb", "-q", "-j", jobs)
        seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compare_throughput(models: Path, rounds: int) -> str:
    """Run warm processes and batches in turns; the best round of each counts, which others disturbed least."""
    cores = len(os.sched_getaffinity(0))
    sample, many = choose_files(models, SAMPLE), choose_files(models, 4 * SAMPLE)
    one, beside, whole = [], [], []
    for _ in range(rounds):
        one.append(run_warm_processes(sample[: SAMPLE // 2], 1))
        beside.append(run_warm_processes(sample, cores))
        seconds, used = time_batch(many, cores)
        whole.append((len(many) / seconds, used / len(many)))
    best = {
        "one warm process": (max(speed for speed, _ in one), min(used for _, used in one)),
        f"{cores} warm processes side by side": (max(speed for speed, _ in beside), min(used for _, used in beside)),
        f"batch, {cores} jobs, from start to end": (max(speed for speed, _ in whole), min(used for _, used in whole)),
    }
    (single, used_single), (together, used_together), (ours, used) = best.values()
    return "\n".join([
        f"Best of {rounds} rounds; {len(sample):,} files for the warm processes, {len(many):,} for the batch:",
        "",
        format_table(
            ["", "files/s", "processor ms of a file"],
            [[name, speed, 1e3 * used] for name, (speed, used) in best.items()],
        ),
        "",
        f"The batch has {ours / single / cores:.3f} x cores x the throughput of one warm process, and"
        f" {ours / together:.3f} x that of {cores} side by side; by processor time {used_single / used:.3f} x and"
        f" {used_together / used:.3f} x. It hashes every input and result besides, and starts.",
    ])  # fmt: skip


def measure_memory(models: Path, count: int) -> str:
    """Run all buildings at once, and measure the memory at each tenth of the way."""
    with make_scratch_folder() as out:
        levels: list[tuple[int, int]] = []
        leading = 0.0
        manifest = out / "out" / "manifest.jsonl"
        start = time.perf_counter()
        process = subprocess.Popen([*OURS, "batch", models, out / "out", "--to", "glb", "-q"])
        while process.poll() is None:
            time.sleep(0.5)
            ended = manifest.read_bytes().count(b"\n") if manifest.exists() else 0
            if process.poll() is None:
                leading = measure_processor(process.pid)
            if ended * 10 // count >= len(levels) and process.poll() is None:
                levels.append((ended, measure_resident(process.pid)))
        seconds = time.perf_counter() - start
        rows = list(read_manifest(str(manifest)))
        manifest_bytes = manifest.stat().st_size
    assert sum(not row.failed for row in rows) == count
    triangles = sum(row.triangles_before or 0 for row in rows)
    sizes = [sum(row.input_bytes for row in rows), sum(row.output_bytes or 0 for row in rows)]
    return "\n".join([
        f"{count:,} buildings, {triangles:,} triangles, {sizes[0] / 1e6:,.0f} MB -> {sizes[1] / 1e6:,.0f} MB,"
        f" {count / seconds:.1f} files/s. The leading process takes {1e6 * leading / count:.0f} us of the processor"
        f" for each file, its start and the planning included; the manifest has {manifest_bytes / count:.0f} bytes for"
        " each.",
        "",
        format_table(["files", "memory of all processes, MB"], [[ended, level / 1e6] for ended, level in levels]),
    ])  # fmt: skip


def measure_processor(process: int) -> float:
    """Return the processor seconds of a process itself."""
    words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def compare_with_loop(models: Path) -> str:
    """Compare a shell loop of `bldsimp simplify` with a batch of the same files."""
    paths = choose_files(models, LOOP)
    with make_scratch_folder() as out:
        script = 'for path in "$@"; do n=$((n + 1)); "$python" -c "$ours" simplify "$path" "$out/$n.glb" -q; done'
        start = time.perf_counter()
        subprocess.run(
            ["sh", "-c", script, "sh", *map(str, paths)],
            env=os.environ | {"python": sys.executable, "ours": OURS[2], "out": str(out)},
            check=True,
        )
        in_loop = time.perf_counter() - start
        start = time.perf_counter()
        run_batch(*paths, out / "out", "--to", "glb", "-q")
        together = time.perf_counter() - start
    return (
        f"{len(paths)} files: shell loop {in_loop:.1f} s, {1e3 * in_loop / len(paths):.0f} ms for each; batch"
        f" {together:.2f} s with its start: {in_loop / together:.1f} x as fast."
    )


def read_results(folder: Path) -> dict[str, bytes]:
    """Read all results, hidden files too."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.name.startswith((".manifest", "manifest"))
    }


def kill_runs(models: Path) -> str:
    """Kill a run at ten random moments, then resume it, and compare the results with those of a whole run."""
    moment = random.Random(0)
    with make_scratch_folder() as out:
        some = choose_files(models, SAMPLE)
        linked = out / "models"
        linked.mkdir()
        for path in some:
            (linked / path.name).symlink_to(path)
        run_batch(linked, out / "whole", "--to", "glb", "-q")
        manifest = out / "out" / "manifest.jsonl"
        recorded = [0]
        for _ in range(10):
            process = subprocess.Popen([*OURS, "batch", linked, out / "out", "--to", "glb", "--resume", "-q"])
            while not manifest.exists() or manifest.read_bytes().count(b"\n") <= recorded[-1]:
                time.sleep(0.01)
            time.sleep(moment.uniform(0.0, 1.0))
            process.kill()
            process.wait()
            recorded.append(manifest.read_bytes().count(b"\n"))
        run_batch(linked, out / "out", "--to", "glb", "--resume", "-q")
        names = [row.input for row in read_manifest(str(manifest)) if not row.failed]
        same = read_results(out / "out") == read_results(out / "whole")
    return (
        f"{len(some):,} files, killed when {', '.join(map(str, recorded[1:]))} rows were recorded, then resumed:"
        f" results {'are the same bytes as' if same else 'DIFFER from'} those of a whole run,"
        f" {len(names):,} rows for {len(set(names)):,} files."
    )


def run_bad_files(models: Path) -> str:
    """Run bad files among a thousand good ones."""
    with make_scratch_folder() as out:
        folder = out / "models"
        folder.mkdir()
        good = choose_files(models, SAMPLE)
        for path in good:
            (folder / path.name).symlink_to(path)
        glb = next(path for path in good if path.suffix == ".glb").read_bytes()
        (folder / "cut.glb").write_bytes(glb[: len(glb) // 2])
        for suffix in ("obj", "stl"):
            with open(folder / f"sparse_{suffix}.{suffix}", "wb") as stream:
                stream.truncate(2_000_000_000)
        os.mkfifo(folder / "pipe.obj")
        (folder / "loop.obj").symlink_to("loop.obj")
        (folder / "round").symlink_to(folder)
        shutil.copy(good[0], folder / f"two\nlines{good[0].suffix}")
        shutil.copy(good[0], folder / os.fsdecode(b"latin\xe9" + os.fsencode(good[0].suffix)))
        write_terrain(folder / "grows.obj", 600)
        done = run_batch(folder, out / "out", "--to", "glb", "--memory", "600M", check=False)
        rows = list(read_manifest(str(out / "out" / "manifest.jsonl")))
        lines = [[row.input, row.kind, row.attempts, row.error] for row in rows if row.failed]
    count = sum(not row.failed for row in rows)
    return f"Exit code {done.returncode}; {count:,} of {len(good) + 2:,} good files done.\n\n" + format_table(
        ["file", "kind", "attempts", "error"], [[str(cell).replace(str(out), "...") for cell in line] for line in lines]
    )


def write_terrain(path: Path, side: int) -> None:
    """Write a rough surface as OBJ, which needs far more memory than a flat one."""
    chance = random.Random(0)
    with open(path, "w", encoding="ascii") as stream:
        for x in range(side):
            for y in range(side):
                stream.write(f"v {x} {y} {chance.gauss(0, 1):.6f}\n")
        for x in range(side - 1):
            for y in range(side - 1):
                a = x * side + y + 1
                stream.write(f"f {a} {a + side} {a + side + 1}\nf {a} {a + side + 1} {a + 1}\n")


def measure_planning(count: int) -> list[object]:
    """Measure the processor seconds and memory to find files, read their manifest, and see that all are done."""
    with make_scratch_folder() as folder:
        for i in range(count):
            district = folder / "models" / f"{i // 1000:05}"
            if i % 1000 == 0:
                district.mkdir(parents=True)
                (folder / "out" / district.name).mkdir(parents=True)
            (district / f"building_{i:08}.obj").touch()
            (folder / "out" / district.name / f"building_{i:08}.glb").touch()
        layout = OutputLayout(str(folder / "out"), "{stem}.{ext}", "glb")
        before = measure_own_memory()
        start = time.process_time()
        tasks = plan_tasks(find_inputs([str(folder / "models")], layout.root), layout).tasks
        found = time.process_time()
        manifest = open_manifest(str(folder / "out" / "manifest.jsonl"), resume=True, overwrite=False)
        for task in tasks:
            manifest.append(invent_row(task))
        manifest.close()
        written = time.process_time()
        done = collect_done(read_manifest(manifest.path), Options())  # type: ignore[union-attr]
        read = time.process_time()
        left = select_remaining(tasks, done, layout.root, verify=False, jobs=2)
        compared = time.process_time()
        held = measure_own_memory() - before
    assert len(tasks) == count
    assert not left
    return [
        count, found - start, written - found, read - written, compared - read,
        1e6 * (compared - written + found - start) / count, held / count,
    ]  # fmt: skip


def measure_own_memory() -> int:
    """Return the bytes of memory that this process has."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def invent_row(task: Task) -> FileRow:
    """Make up the row of a file that is done."""
    from bldsimp import __version__

    return make_row(
        task, DONE, input_mtime_ns=task.mtime,
        input_sha256="0" * 64, output_bytes=0, output_sha256="0" * 64, points_before=1000, points_after=100,
        triangles_before=2000, triangles_after=200,
        tolerance=1e-5, deviation=1e-6, seconds=0.01, version=__version__,
    )  # fmt: skip


def compare_with_cluster(models: Path) -> str:
    """Compare a cluster of two workers on this machine with the pool, over the same files."""
    paths = choose_files(models, 2 * SAMPLE)
    with make_scratch_folder() as out, socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        free.close()
        address = f"tcp://127.0.0.1:{port}"
        scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port)]
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1"]
        processes = []
        try:
            for command in (scheduler, worker, worker):
                processes.append(subprocess.Popen([*command, "--no-dashboard"], cwd=out, stderr=subprocess.DEVNULL))
            in_pool, _ = time_batch(paths, 2)
            # In this process and a second time, so that nothing is loaded meanwhile.
            for name in ("first", "second"):
                start, used = time.perf_counter(), time.process_time()
                words = [*map(str, paths), str(out / name), "--to", "glb", "-q", "--scheduler", address]
                assert program(["batch", *words]) == 0
                seconds, leading = time.perf_counter() - start, (time.process_time() - used) / len(paths)
        finally:
            for process in processes[::-1]:
                process.terminate()
                process.wait()
    return (
        f"{len(paths):,} files: pool of two {in_pool:.1f} s, its start included; cluster with two workers, everything"
        f" loaded, {seconds:.1f} s. The leading process takes {1e6 * leading:.0f} us of the processor for each file."
    )


def measure_plans() -> str:
    """Measure planning and resuming at growing sizes, by processor time."""
    rows = [measure_planning(count) for count in (12_500, 25_000, 50_000, 100_000)]
    steps = ["find and plan, s", "append rows, s", "read manifest, s", "compare, s"]
    return format_table(["files", *steps, "us for each but for appending", "bytes held for each"], rows)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--sections", default="turns,memory,loop,dask,kills,poison,plan")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--folder", type=Path)
    args = parser.parse_args()
    with make_scratch_folder() as here:
        folder = args.folder or here
        if not folder.is_dir() or not any(folder.iterdir()):
            make_buildings(folder, args.files)
        sections: dict[str, tuple[str, Callable[[], str]]] = {
            "turns": ("Throughput", lambda: compare_throughput(folder, args.rounds)),
            "memory": ("Memory over a long run", lambda: measure_memory(folder, args.files)),
            "loop": ("Beside a shell loop", lambda: compare_with_loop(folder)),
            "dask": ("On a cluster", lambda: compare_with_cluster(folder)),
            "kills": ("Killed ten times", lambda: kill_runs(folder)),
            "poison": ("Bad files", lambda: run_bad_files(folder)),
            "plan": ("Planning and resuming", measure_plans),
        }
        for name in args.sections.split(","):
            title, figures = sections[name]
            print(f"### {title}\n\n{figures()}\n", flush=True)


if __name__ == "__main__":
    main()
