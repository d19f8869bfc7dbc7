"""Edit after edit in one process: what an edit leaves as it was is neither read, bound nor solved again."""

from __future__ import annotations

from pathlib import Path

from scenec.bind.asset_library import AssetLibrary
from scenec.compile import Compiled, compile_program
from scenec.ir.derivation_cache import Memo
from scenec.solve import DEFAULT_BUDGET, ComponentCache
from scenec.source.incremental_parse import Pieces


class Session:
    """Compiles programs one after another and keeps texts, assets, components and the last scenes between them.

    Each scene is whole, and what an edit may have changed is judged as by `compile_program`; where things stand may
    depend on the edits before, because what can stay where it was stays there. Packages that changed on disk are read
    anew.
    """

    def __init__(
        self, assets: Path | None = None, *, seed: int = 0, budget: int = DEFAULT_BUDGET, root: Path | None = None
    ) -> None:
        self.seed, self.budget, self.root = seed, budget, root
        self.library, self.cache, self.pieces = AssetLibrary(assets), ComponentCache(), Pieces()
        self.memo = Memo()
        self.last: Compiled | None = None

    def compile(self, path: Path, *, explain: bool = True) -> Compiled:
        """As `compile_program`. An edit that gives no scene is forgotten: the next starts from the last scene."""
        self.library.refresh()
        compiled = compile_program(
            path,
            seed=self.seed,
            budget=self.budget,
            root=self.root,
            previous=self.last,
            cache=self.cache,
            library=self.library,
            pieces=self.pieces,
            memo=self.memo,
            explain=explain,
        )
        if compiled.scenes:
            self.last = compiled
            self.memo.turn()
        return compiled
