"""Where the cells of a batch run: on this machine, or on a dask.distributed cluster. One small interface for all."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from jobs.warm import warm_cells

Notice = Callable[[str], None]  # takes one line for the user


class ClusterUnusable(Exception):
    """No cell can run on the cluster; the text is one line with the address and the reason."""


def _unheard(_: str) -> None:
    """Drops a line that nobody wants."""


@dataclass(frozen=True)
class Placement:
    """Where cells run, and how many at a time.

    `scheduler` is None for threads of this process that start cells here: the default, and fastest on one machine.
    Else the address of a dask scheduler, or "local" for a LocalCluster of this machine (`jobs.cluster`), whose workers
    decide how many cells run at a time; `jobs` counts only with None and "local". `notice` is called with a line for
    each worker that cannot be used.
    """

    jobs: int = 1
    scheduler: str | None = None
    notice: Notice = field(default=_unheard, compare=False)


ONE_CELL = Placement()  # one cell at a time, on this machine


@contextlib.contextmanager
def cells_at(
    placement: Placement, preload: str, *, env: Mapping[str, str], shared: Sequence[Path], needed: Sequence[Path] = ()
) -> Iterator[int | Callable[[], int]]:
    """Within it, `jobs.warm.run_module` runs its cells at `placement`; gives the `jobs` for `jobs.schedule.run_all`.

    `preload` is a module that is imported once for many cells, with `env` added to the environment. `shared` are the
    folders that every machine has to share, under the same path, and `needed` files and folders that it only reads.
    Raises ClusterUnusable for an unusable cluster.
    """
    if placement.scheduler is None:
        with warm_cells(preload, env=dict(env)):
            yield placement.jobs
        return
    from jobs.cluster import cluster_cells  # Loads distributed, which most runs do not need.

    where, jobs, notice = placement.scheduler, placement.jobs, placement.notice
    with cluster_cells(where, preload, shared=shared, needed=needed, env=env, jobs=jobs, notice=notice) as cluster:
        yield lambda: cluster.capacity
