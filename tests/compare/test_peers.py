"""Other tools: only those installed are run, each with the same limit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from comparisons import find_row
from shapes import fine_box, obj_text, open_cone, write

from bldsimp.compare.measure import Judge
from bldsimp.compare.peers import PEERS, Peer, find_peers
from bldsimp.compare.rows import compare_file


class TestPeers:
    def test_only_what_is_installed_is_asked_and_nothing_loaded(self) -> None:
        code = (
            "import sys; from bldsimp.compare.peers import find_peers; print([p.name for p in find_peers()]);"
            "assert not {'manifold3d', 'meshoptimizer', 'open3d', 'pymeshlab', 'pyfqmr'} & set(sys.modules)"
        )
        told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        assert told.strip() == str([peer.name for peer in find_peers()])
        assert [peer.name for peer in PEERS] == ["manifold3d", "meshoptimizer", "open3d", "pymeshlab", "pyfqmr"]

    @pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
    def test_each_reduces_a_fine_box_at_the_same_deviation(self, peer: Peer, tmp_path: Path) -> None:
        pytest.importorskip(peer.name, reason=f"{peer.name} is not installed")
        path = write(tmp_path / "box.obj", obj_text(*fine_box(8)))
        comparison = compare_file(path, "obj", "box", ["0.01"], [peer])
        one = comparison.rows[-1]
        assert one.method == peer.name
        assert one.points is not None, one.note
        assert 8 <= one.points < 386
        assert one.deviation <= find_row(comparison, "improved", "0.01").deviation + Judge(comparison.original).blur
        assert one.watertight
        assert one.seconds > 0.0

    def test_manifold_refuses_what_is_open(self, tmp_path: Path) -> None:
        pytest.importorskip("manifold3d", reason="manifold3d is not installed")
        path = write(tmp_path / "cone.obj", obj_text(*open_cone()))
        one = compare_file(path, "obj", "cone", ["0.1"], [PEERS[0]]).rows[-1]
        assert one.points is None
        assert one.note.startswith("refuses the input: NotManifold")
