"""The parts of `batch`, each alone: names, globs, groups, memory, manifests, what is done already."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from batch_runs import write_buildings
from hypothesis import given
from hypothesis import strategies as st

from bldsimp import Options, UsageError, __version__
from bldsimp.batch import resume, worker
from bldsimp.batch.inputs import OutputLayout, find_inputs, parse_names, plan_tasks
from bldsimp.batch.manifest import open_manifest, read_manifest
from bldsimp.batch.memory import choose_jobs, divide_memory
from bldsimp.batch.pool import Group, GroupQueue
from bldsimp.batch.process import simplify_task
from bldsimp.batch.row import DONE, FileRow, escape_name, make_failure, unescape_name
from bldsimp.batch.storage import join_path
from bldsimp.batch.task import Task, WorkOrder, encode_options, split_into_groups
from bldsimp.cli import main
from bldsimp.cli.batch import batch
from bldsimp.cli.simplify import simplify
from bldsimp.display import parse_bytes
from bldsimp.options import parse_tolerance

names = st.binary(min_size=1, max_size=20).map(os.fsdecode)


def task(name: str, size: int = 1, mtime: int = 1) -> Task:
    return Task("/in", name, "/out", f"{name}.glb", "obj", "glb", size, mtime)


def make_done_row(task: Task, output_bytes: int = 1) -> FileRow:
    """The row of a task that is done."""
    row = make_failure(task, "input", "")
    row.status, row.kind, row.error, row.output_bytes = DONE, None, None, output_bytes
    row.options, row.version = encode_options(Options()), __version__
    return row


class TestNames:
    @given(names)
    def test_any_name_comes_back_from_a_line_of_utf8(self, name: str) -> None:
        line = make_failure(task(name), "input", f"{name}: no model").to_line()
        assert line.count(b"\n") == 1
        assert unescape_name(json.loads(line.decode("utf-8"))["input"]) == name
        assert FileRow.from_line(line).input == name

    @given(names, names)
    def test_no_two_names_are_written_alike(self, one: str, other: str) -> None:
        assert (escape_name(one) == escape_name(other)) is (one == other)

    def test_plain_names_stay_as_they_are(self) -> None:
        assert escape_name("Gebäude 1/日本.obj") == "Gebäude 1/日本.obj"
        assert escape_name("100%") == "100%25"

    def test_a_list_of_names_may_hold_newlines_where_zero_bytes_part_them(self) -> None:
        assert parse_names(b"a\nb.obj\0\xff.obj\0") == ["a\nb.obj", os.fsdecode(b"\xff.obj")]
        assert parse_names(b"a.obj\r.obj\n\n b.obj\n") == ["a.obj\r.obj", " b.obj"]


class TestInputs:
    @pytest.mark.parametrize(
        ("pattern", "found"),
        [
            ("*.obj", ["a.obj"]),
            ("**/*.obj", ["a.obj", "x/[c].obj", "x/b.obj", "x/y/a.obj"]),
            ("x/*.obj", ["x/[c].obj", "x/b.obj"]),
            ("x/**", ["x/[c].obj", "x/b.obj", "x/b.ply", "x/y/a.obj"]),
            ("?/[!a].obj", ["x/b.obj"]),
            ("x/[[]c].obj", ["x/[c].obj"]),
            ("x/[c].obj", ["x/[c].obj"]),
        ],
    )
    def test_globs(self, pattern: str, found: list[str], tmp_path: Path) -> None:
        for name in ("a.obj", "x/b.obj", "x/b.ply", "x/[c].obj", "x/y/a.obj", "x/.hidden/a.obj", "out/a.obj"):
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).touch()
        inputs = find_inputs([str(tmp_path / pattern)], str(tmp_path / "out"))
        assert [os.path.relpath(join_path(each.root, each.entry.name), tmp_path) for each in inputs] == found

    def test_an_input_that_is_named_twice_is_one(self, tmp_path: Path) -> None:
        folder = write_buildings(tmp_path / "models", 3)
        layout = OutputLayout(str(tmp_path / "out"), "{stem}.{ext}")
        inputs = find_inputs([str(folder), str(folder / "**" / "*.obj")], layout.root)
        assert len(plan_tasks(inputs, layout).tasks) == 3

    def test_an_input_is_not_overwritten_through_a_link(self, tmp_path: Path) -> None:
        folder = write_buildings(tmp_path / "models", 3)
        (tmp_path / "link").symlink_to(folder)
        layout = OutputLayout(str(tmp_path / "link"), "{stem}.{ext}")
        with pytest.raises(UsageError, match="would be overwritten"):
            plan_tasks(find_inputs([str(folder / "**" / "*.obj")], layout.root), layout)


class TestOptions:
    def test_all_that_simplify_may_be_told_of_a_file_batch_may_be_told_of_each(self) -> None:
        taken, given = ({option.name: option for option in command.params} for command in (batch, simplify))
        for name in vars(Options()).keys() - {"baseline"}:
            assert taken[name].to_info_dict() == given[name].to_info_dict()


class TestGroups:
    @given(st.lists(st.integers(0, 100), max_size=60), st.integers(1, 9), st.integers(1, 300))
    def test_all_tasks_in_few_groups_the_largest_first(self, sizes: list[int], files: int, size: int) -> None:
        tasks = [task(str(i), size) for i, size in enumerate(sizes)]
        groups = list(split_into_groups(tasks, files, size))
        flat = [each for group in groups for each in group]
        assert sorted(flat, key=lambda each: int(each.name)) == tasks
        assert [each.size for each in flat] == sorted(sizes, reverse=True)
        for group in groups:
            assert len(group) <= files
            assert len(group) == 1 or sum(each.size for each in group) <= size
        for group, following in pairwise(groups):
            assert len(group) == files or sum(each.size for each in group) + following[0].size > size

    def test_groups_that_do_not_fit_together_wait(self) -> None:
        groups = GroupQueue(10, bool)
        large, small, second = Group([task("large")], 7), Group([task("small")], 2), Group([task("second")], 6)
        groups.fill([large, second, small], 2)
        assert groups.take() == large
        assert groups.take() == small
        groups.release(large)
        assert groups.take() == second

    def test_a_second_try_comes_last_and_with_the_memory_that_it_asks_for(self) -> None:
        groups = GroupQueue(10, bool)
        first, other, again = Group([task("first")], 5), Group([task("other")], 5), Group([task("first")], 10)
        groups.fill([first, other], 5)
        assert groups.take() == first
        groups.add(again)
        groups.release(first)
        assert groups.take() == other
        groups.release(other)
        assert groups.take() == again
        groups.release(again)
        assert groups.take() is None


class TestMemory:
    @pytest.mark.parametrize(
        ("text", "count"), [("8G", 8 * 10**9), ("1.5 gb", 1_500_000_000), ("300m", 300_000_000), ("12", 12)]
    )
    def test_amounts(self, text: str, count: int) -> None:
        assert parse_bytes(text) == count

    @pytest.mark.parametrize("text", ["", "G", "-1G", "8X", "1e9"])
    def test_what_is_no_amount(self, text: str) -> None:
        with pytest.raises(UsageError, match="not an amount"):
            parse_bytes(text)

    @given(st.integers(200 * 10**6, 10**12), st.integers(1, 256))
    def test_no_more_jobs_than_there_is_memory_for(self, memory: int, cores: int) -> None:
        jobs = choose_jobs(memory, cores)
        assert 1 <= jobs <= cores
        divide_memory(memory, jobs)

    def test_shares_leave_room_for_the_workers_themselves(self) -> None:
        together, each = divide_memory(8 * 10**9, 4)
        assert 4 * each <= together < 8 * 10**9


class TestManifest:
    def lines(self, path: Path) -> Iterator[str]:
        return (row.input for row in read_manifest(str(path)))

    def test_a_torn_line_is_cut_and_rows_follow_it(self, tmp_path: Path) -> None:
        path = tmp_path / "manifest.jsonl"
        first, second, third = (make_done_row(task(name)).to_line() for name in "abc")
        path.write_bytes(first + second[:-9])
        manifest = open_manifest(str(path), resume=True, overwrite=False)
        assert [row.input for row in manifest.rows()] == ["a"]
        manifest.append(FileRow.from_line(third))
        manifest.close()
        assert path.read_bytes() == first + third
        assert list(self.lines(path)) == ["a", "c"]

    @pytest.mark.parametrize("damage", [b"\0" * 40 + b"\n", b"[]\n", b'{"input": 3}\n', b"\xff\n"])
    def test_a_line_that_is_none_costs_no_other(self, damage: bytes, tmp_path: Path) -> None:
        path = tmp_path / "manifest.jsonl"
        path.write_bytes(make_done_row(task("a")).to_line() + damage + make_done_row(task("b")).to_line())
        assert list(self.lines(path)) == ["a", "b"]

    def test_fields_of_a_later_version_are_left_out(self, tmp_path: Path) -> None:
        path = tmp_path / "manifest.jsonl"
        line = make_done_row(task("a")).to_line().replace(b"}\n", b',"color":"red"}\n')
        path.write_bytes(line)
        manifest = open_manifest(str(path), resume=True, overwrite=False)
        assert [row.input for row in manifest.rows()] == ["a"]
        manifest.close()
        assert path.read_bytes() == line

    def test_one_that_exists_is_kept_unless_said(self, tmp_path: Path) -> None:
        path = tmp_path / "manifest.jsonl"
        path.write_bytes(make_done_row(task("a")).to_line())
        with pytest.raises(UsageError, match="--resume"):
            open_manifest(str(path), resume=False, overwrite=False)
        assert list(self.lines(path)) == ["a"]
        open_manifest(str(path), resume=False, overwrite=True).close()
        assert path.read_bytes() == b""


class TestWorker:
    def test_a_process_that_ends_by_itself_tells_how(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """However long that takes after the last that was heard from it."""
        monkeypatch.setattr(
            worker,
            "_PROGRAM",
            "import sys, time; sys.path[:] = {!r}; from multiprocessing.connection import Connection\n"
            "here = Connection({}); here.send(True); here.recv(); here.close(); time.sleep(0.3); sys.exit('no more')",
        )
        order = WorkOrder([task("a")], Options(), overwrite=False)
        ((_, row),) = worker.Worker().run(order, None, bool)
        assert (row.kind, row.error) == ("crash", "its process ended with code 1: no more")

    def test_a_file_that_takes_too_long_fails_and_the_next_one_is_done(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(
            worker,
            "_PROGRAM",
            "import sys, time; sys.path[:] = {!r}; from multiprocessing.connection import Connection\n"
            "here = Connection({}); here.send(True); tasks = here.recv().tasks\n"
            "if len(tasks) > 1: time.sleep(1000)\n"
            "from bldsimp.batch.row import make_row; here.send(make_row(tasks[0], 'done')); here.recv()",
        )
        order = WorkOrder([task("hangs"), task("good")], Options(), overwrite=False)
        hangs, good = (row for _, row in worker.Worker().run(order, 1.0, bool))
        assert (hangs.input, hangs.kind, hangs.error) == (
            "hangs", "timeout", "took longer than 1 s: give a larger --timeout",
        )  # fmt: skip
        assert (good.input, good.failed) == ("good", False)

    def test_one_that_neither_answers_nor_ends_is_killed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(worker, "LEAVE_SECONDS", 0.1)
        monkeypatch.setattr(
            worker,
            "_PROGRAM",
            "import sys, time; sys.path[:] = {!r}; from multiprocessing.connection import Connection\n"
            "here = Connection({}); here.send(True); here.recv(); here.close(); time.sleep(1000)",
        )
        ((_, row),) = worker.Worker().run(WorkOrder([task("a")], Options(), overwrite=False), None, bool)
        assert (row.kind, row.error) == ("crash", "its process did not answer")


class TestRemaining:
    def test_each_file_is_asked_for_once(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Neither reading a manifest nor planning from it grows faster than the files."""
        tasks = [task(f"{i}.obj") for i in range(1000)]
        counted = {"looked": 0, "hashed": 0}

        class Counted:
            def list_sizes(self, root: str):  # type: ignore[no-untyped-def]
                def size(name: str) -> int:
                    counted["looked"] += 1
                    return 1

                return size

            def open(self, path: str):  # type: ignore[no-untyped-def]
                counted["hashed"] += 1
                raise FileNotFoundError(path)

        monkeypatch.setattr(resume, "open_storage", lambda text: Counted())
        # Ten were touched since, ten are of another size, and ten were never done.
        rows = [make_done_row(each) for each in tasks[:990]]
        for row in rows[:10]:
            row.input_mtime_ns += 1
        for row in rows[10:20]:
            row.input_bytes += 1
        left = resume.select_remaining(tasks, resume.collect_done(iter(rows), Options()), "/out", verify=False, jobs=2)
        assert {each.name for each in left} == {each.name for each in [*tasks[:20], *tasks[990:]]}
        assert counted == {"looked": 990, "hashed": 10}

    def test_the_last_row_of_a_file_counts(self) -> None:
        good, bad = make_done_row(task("a")), make_failure(task("a"), "input", "no model")
        assert resume.collect_done([good, bad], Options()) == {}
        assert list(resume.collect_done([bad, good], Options())) == ["a"]

    def test_other_options_or_another_version_count_as_not_done(self) -> None:
        row = make_done_row(task("a"))
        assert resume.collect_done([row], Options(tolerance=parse_tolerance("1%"))) == {}
        row.version = "0.0.1"
        assert resume.collect_done([row], Options()) == {}


class TestUrls:
    @pytest.fixture
    def memory(self):  # type: ignore[no-untyped-def]
        """The storage of fsspec's that is in memory, empty."""
        fsspec = pytest.importorskip("fsspec")
        system = fsspec.filesystem("memory")
        yield system
        system.store.clear()

    def test_inputs_outputs_and_manifest(self, memory, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
        folder = write_buildings(tmp_path / "models", 6)
        memory.put(str(folder), "memory://models", recursive=True)
        layout = OutputLayout("memory://out", "{stem}.{ext}", "glb")
        todo = plan_tasks(find_inputs(["memory://models"], layout.root), layout)
        manifest = open_manifest("memory://out/manifest.jsonl", resume=True, overwrite=False)
        assert manifest.empty
        for each in todo.tasks:
            row = simplify_task(each, WorkOrder([each], Options(), overwrite=False))
            row.options, row.version = encode_options(Options()), __version__
            manifest.append(row)
        manifest.close()
        rows = list(read_manifest("memory://out/manifest.jsonl"))
        assert {row.input for row in rows} == {str(path.relative_to(folder)) for path in folder.rglob("*.*")}
        for row in rows:
            assert memory.info(f"memory://out/{row.output}")["size"] == row.output_bytes
            assert (row.points_before, row.points_after) == (98, 8)
        done = resume.collect_done(rows, Options())
        assert resume.select_remaining(todo.tasks, done, layout.root, verify=True, jobs=2) == []
        memory.rm_file(f"memory://out/{rows[0].output}")
        left = resume.select_remaining(todo.tasks, done, layout.root, verify=False, jobs=2)
        assert [each.name for each in left] == [rows[0].input]

    def test_a_manifest_is_gone_on_with_in_another_part(self, memory) -> None:  # type: ignore[no-untyped-def]
        url = "memory://out/manifest.jsonl"
        for name in "ab":
            manifest = open_manifest(url, resume=True, overwrite=False)
            manifest.append(make_done_row(task(name)))
            manifest.close()
        assert [row.input for row in read_manifest(url)] == ["a", "b"]
        with pytest.raises(UsageError, match="--resume"):
            open_manifest(url, resume=False, overwrite=False)
        assert open_manifest(url, resume=False, overwrite=True).empty

    def test_file_urls_are_paths(self, tmp_path: Path) -> None:
        folder = write_buildings(tmp_path / "models", 2)
        assert main(["batch", f"file://{folder}", f"file://{tmp_path}/out", "-q"]) == 0
        assert len(list((tmp_path / "out").rglob("building*"))) == 2

    def test_an_unknown_scheme(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match=r"bldsimp\[dask\]"):
            list(find_inputs(["nowhere://models"], str(tmp_path)))
