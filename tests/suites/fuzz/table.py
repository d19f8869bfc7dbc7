"""Rows and figures of a fuzz run: inputs, refusals, internal errors, overruns, seconds, memory."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from typing import Self

from assetkit.batch.item_cells import LOST_CODES
from tests.suites.fuzz.seeds import Seed

OUR_DEFECTS = frozenset({"asset/internal-error", "asset/package-invalid", *LOST_CODES.values()})


@dataclass(frozen=True)
class Row:
    """One case. `ended` is empty where the cell went on, else how it ended: `timeout`, `crashed`, `out_of_memory`."""

    format: str
    seed: str
    number: int
    done: str
    made: int = 0
    codes: tuple[str, ...] = ()
    broken: tuple[str, ...] = ()
    trace: str = ""
    ended: str = ""
    wall_s: float = 0.0
    peak_mb: float = 0.0

    @classmethod
    def from_note(cls, seed: Seed, note: dict[str, object]) -> Self:
        """The row of a case that has ended by itself."""
        codes, broken = note.get("codes"), note.get("broken")
        return cls(
            format=seed.format,
            seed=seed.name,
            number=int(str(note["end"])),
            done=str(note["done"]),
            made=int(str(note.get("made", 0))),
            codes=tuple(codes) if isinstance(codes, list) else (),
            broken=tuple(broken) if isinstance(broken, list) else (),
            trace=str(note.get("trace", "")),
            ended="out_of_memory" if note.get("memory") else "",
            wall_s=float(str(note["wall_s"])),
            peak_mb=float(str(note["peak_mb"])),
        )

    @property
    def failure(self) -> str:
        """What is wrong with us, empty where nothing is."""
        if self.ended:
            return self.ended
        if self.trace or OUR_DEFECTS & set(self.codes):
            return "internal error"
        return "broken promise" if self.broken else ""

    def text(self) -> str:
        """The case for a person, with the end of its trace."""
        head = f"{self.failure.upper()} {self.format} {self.seed} #{self.number} [{self.done}] {self.broken or ''}"
        return f"{head!r}\n{self.trace[-1200:]}"


@dataclass
class Tally:
    """Figures by format."""

    inputs: Counter[str] = field(default_factory=Counter)
    values: Counter[str] = field(default_factory=Counter)
    failed: defaultdict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    codes: defaultdict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    seconds: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    peak_mb: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))

    def add(self, row: Row) -> None:
        """Count a case."""
        name = row.format
        self.inputs[name] += 1
        self.values[name] += row.made > 0
        self.codes[name].update(row.codes)
        self.seconds[name].append(row.wall_s)
        self.peak_mb[name] = max(self.peak_mb[name], row.peak_mb)
        if row.failure:
            self.failed[name][row.failure] += 1

    @property
    def failures(self) -> int:
        """Cases that are our fault."""
        return sum(counter.total() for counter in self.failed.values())


def table(tally: Tally) -> str:
    """A line per format."""
    words = ("internal error", "broken promise", "crashed", "timeout", "out_of_memory")
    lines = [f"| format | inputs | values | codes | {' | '.join(words)} | median s | most s | peak MiB |"]
    lines.append("|" + "---|" * (len(words) + 7))
    for name in sorted(tally.inputs):
        seconds = sorted(tally.seconds[name])
        counts = " | ".join(str(tally.failed[name][word]) for word in words)
        figures = f"{seconds[len(seconds) // 2]:.3f} | {seconds[-1]:.2f} | {tally.peak_mb[name]:.0f}"
        head = f"{name} | {tally.inputs[name]} | {tally.values[name]} | {len(tally.codes[name])}"
        lines.append(f"| {head} | {counts} | {figures} |")
    return "\n".join(lines)
