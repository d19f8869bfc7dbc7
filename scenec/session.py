"""Compile session: parts of a program that an edit leaves unchanged are neither read, bound nor solved again."""

from __future__ import annotations

from pathlib import Path

from scenec.bind.asset_library import AssetLibrary
from scenec.compile import Compiled, compile_program
from scenec.ir.derivation_cache import DerivationCache
from scenec.solve import DEFAULT_BUDGET, ComponentCache
from source.incremental_parse import IncrementalParser


class Session:
    """Compiles programs one after another and keeps texts, assets, components and the last scenes between them.

    Each scene is complete, and everything that an edit may have changed is judged as by `compile_program`. Placements
    may depend on earlier edits, because things stay where they were if they can. Packages that changed on disk are read
    again.
    """

    def __init__(
        self, assets: Path | None = None, *, seed: int = 0, budget: int = DEFAULT_BUDGET, root: Path | None = None
    ) -> None:
        self.seed, self.budget, self.root = seed, budget, root
        self.library, self.cache, self.parser = AssetLibrary(assets), ComponentCache(), IncrementalParser()
        self.derivations = DerivationCache()
        self.last: Compiled | None = None

    def compile(self, path: Path, *, explain: bool = True) -> Compiled:
        """As `compile_program`. An edit without a scene is not kept: the next starts from the last scene."""
        self.library.refresh()
        compiled = compile_program(
            path,
            seed=self.seed,
            budget=self.budget,
            root=self.root,
            previous=self.last,
            cache=self.cache,
            library=self.library,
            parser=self.parser,
            derivations=self.derivations,
            explain=explain,
        )
        if compiled.scenes:
            self.last = compiled
            self.derivations.drop_unused()
        return compiled
