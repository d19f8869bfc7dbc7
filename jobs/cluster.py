"""Cells on the workers of a dask.distributed cluster: one that runs, or one of this machine for one batch.

A worker is used when it has Mana in the same version, with the same libraries, and sees the shared folders; any other
is left alone and named with the reason. Each task is one cell with its limits, made by the worker on its machine, so
a worker with n threads runs n cells at a time. Workers may join and leave while a batch runs: cells of a lost worker
are run again elsewhere. A cell ends when its task is cancelled, thus also when the driver dies.
"""

from __future__ import annotations

import asyncio
import contextlib
import platform
import secrets
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from distributed import Client, Future, LocalCluster, Worker, WorkerPlugin, get_worker
from distributed.core import Status
from distributed.scheduler import KilledWorker

from jobs.cell import CANCELLED, CellResult, Limits, is_stopping
from jobs.placement import ClusterUnusable, Notice
from jobs.versions import library_versions
from jobs.warm import ForkServer, run_cold, use_runner

THIS_MACHINE = "local"
CONNECT_TIMEOUT_S = 20.0  # for the scheduler to answer
FIRST_WORKER_TIMEOUT_S = 60.0  # for the first suitable worker, where the cluster starts them on demand
_LOOK_AGAIN_S = 0.5
_REFUSALS = "mana-refused-workers"


@dataclass(frozen=True)
class Cluster:
    """A cluster in use. `capacity` is the number of cells that it can run now, `refused` reason by worker address."""

    client: Client
    resource: str
    refused: dict[str, str] = field(default_factory=dict[str, str])

    @property
    def capacity(self) -> int:
        """Threads of all suitable workers at this moment, at least 1: a batch waits while there is none."""
        workers = self.client.scheduler_info(n_workers=-1)["workers"].values()
        return max(1, sum(int(worker["resources"].get(self.resource, 0)) for worker in workers))


@contextlib.contextmanager
def cluster_cells(
    address: str,
    preload: str,
    *,
    shared: Sequence[Path],
    needed: Sequence[Path] = (),
    env: Mapping[str, str],
    jobs: int,
    notice: Notice = print,
) -> Iterator[Cluster]:
    """Within it, `jobs.warm.run_module` runs its cells on the workers of the cluster at `address`.

    `address` is that of a scheduler ("tcp://host:8786"), or `THIS_MACHINE` for a cluster of `jobs` workers here that
    ends with the context. Workers fork their cells from a process that has imported `preload`, with `env` added to
    its environment. `shared` are folders that every worker must share, `needed` paths that must exist
    there. `notice` gets a line for each worker that is
    refused. Raises ClusterUnusable when the scheduler does
    not answer, or no worker is suitable.
    """
    resource = f"mana-{secrets.token_hex(8)}"
    probe = _Probe(tuple(str(folder.absolute()) for folder in shared), resource)
    with contextlib.ExitStack() as stack:
        try:
            client = stack.enter_context(_connected(address, jobs, stack))
        except (OSError, ValueError) as error:  # TimeoutError is one.
            raise ClusterUnusable(f"the scheduler at {address} does not answer: {error}") from error
        cluster = Cluster(client, resource)

        def refuse(event: tuple[float, tuple[str, str]]) -> None:
            worker, reason = event[1]
            cluster.refused[worker] = reason
            notice(f"worker {worker} is not used: {reason}")

        client.subscribe_topic(_REFUSALS + resource, refuse)
        stack.enter_context(probe)
        guard = SuitableWorkers(resource, _versions(), probe.files, [str(path.absolute()) for path in needed])
        client.register_plugin(guard)
        stack.callback(_forgotten, client, guard.name)
        _await_first_worker(cluster, address)
        stack.enter_context(use_runner(ClusterCells(cluster, preload, dict(env))))
        yield cluster


class ClusterCells:
    """Runs modules in cells of the cluster (a runner of `jobs.warm`)."""

    def __init__(self, cluster: Cluster, preload: str, env: dict[str, str]) -> None:
        self._cluster, self._preload, self._env = cluster, preload, env

    def run(self, name: str, arguments: Sequence[str], limits: Limits, env: dict[str, str]) -> CellResult | None:
        """How the cell ended; `lost` when the workers that had it died, several in a row."""
        if is_stopping():
            return CANCELLED
        future = self._cluster.client.submit(
            remote_cell,
            name,
            list(arguments),
            limits,
            (self._preload, self._env, env),
            pure=False,
            resources={self._cluster.resource: 1},
        )
        ended = threading.Event()
        future.add_done_callback(lambda _: ended.set())
        while not ended.wait(_LOOK_AGAIN_S):
            if is_stopping():
                future.cancel()
                return CANCELLED
        return _result(future)


def remote_cell(
    name: str, arguments: Sequence[str], limits: Limits, home: tuple[str, dict[str, str], dict[str, str]]
) -> CellResult:
    """Run a module in a cell of this worker, until its end or until the task is cancelled. Called on the worker."""
    preload, server_env, env = home
    worker = get_worker()
    key = worker.get_current_task()

    def abandoned() -> bool:
        task = worker.state.tasks.get(key)
        return task is None or task.state in ("cancelled", "released", "forgotten")

    server = _fork_server(preload, server_env)
    result = server.run(name, arguments, limits, env, abandoned=abandoned)
    if result is not None:
        return result
    return run_cold(name, arguments, limits, server_env | env, abandoned=abandoned)


class SuitableWorkers(WorkerPlugin):
    """Marks each worker that can run cells of this batch with the resource `resource`; reports why others cannot."""

    def __init__(
        self, resource: str, versions: dict[str, str], files: Mapping[str, str], needed: Sequence[str]
    ) -> None:
        self.name = resource
        self._versions, self._files, self._needed = versions, dict(files), list(needed)

    async def setup(self, worker: Worker) -> None:
        """Judge the worker, also one that joins late. Called on the worker."""
        reason = await asyncio.to_thread(unsuitable, self._versions, self._files, self._needed)
        if reason:
            worker.log_event(_REFUSALS + self.name, (worker.address, reason))
        else:
            await worker.set_resources(**{self.name: worker.state.nthreads})
            if worker.status is Status.running:
                # The scheduler looks for tasks that wait for such a worker when one is resumed, not for a new resource.
                worker.status = Status.paused
                worker.status = Status.running

    async def teardown(self, worker: Worker) -> None:
        """Take the mark away at the end of the batch."""
        with contextlib.suppress(OSError):
            await worker.set_resources(**{self.name: 0})


def unsuitable(versions: Mapping[str, str], files: Mapping[str, str], needed: Sequence[str] = ()) -> str:
    """Why this process cannot run cells of a batch with these `versions`, probe `files` and `needed` paths, or ""."""
    here = _versions()
    other = sorted(name for name in versions.keys() | here.keys() if versions.get(name) != here.get(name))
    if other:
        shown = [f"{n} {_short(here.get(n, 'absent'))} instead of {_short(versions.get(n, 'none'))}" for n in other]
        return f"other versions: {', '.join(shown)}"
    for file, content in files.items():
        if not _holds(Path(file), content):
            return f"it does not see the folder {Path(file).parent}: it must be on storage that all machines share"
    absent = [path for path in needed if not Path(path).exists()]
    return f"it does not see {absent[0]}, which is to be read" if absent else ""


class _Probe:
    """Files that exist while the batch runs, to see whether a worker sees a folder as this process does."""

    def __init__(self, folders: tuple[str, ...], token: str) -> None:
        self.files = {str(Path(folder) / f".probe-{token}"): token for folder in folders}

    def __enter__(self) -> None:
        for file, token in self.files.items():
            Path(file).write_text(token)

    def __exit__(self, *_: object) -> None:
        for file in self.files:
            Path(file).unlink(missing_ok=True)


_servers: dict[str, ForkServer] = {}
_servers_lock = threading.Lock()


def _fork_server(preload: str, env: dict[str, str]) -> ForkServer:
    """The fork server of this worker for `preload` and `env`; it ends with the worker."""
    with _servers_lock:
        return _servers.setdefault(repr((preload, sorted(env.items()))), ForkServer(preload, env))


@contextlib.contextmanager
def _connected(address: str, jobs: int, stack: contextlib.ExitStack) -> Iterator[Client]:
    if address == THIS_MACHINE:
        cluster: Any = stack.enter_context(
            LocalCluster(n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=":0")
        )
        address = str(cluster.scheduler_address)
    with Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False) as client:
        yield client


def _await_first_worker(cluster: Cluster, address: str) -> None:
    """Return when a suitable worker is there. Raises ClusterUnusable when all are refused, or none comes in time."""
    end = time.monotonic() + FIRST_WORKER_TIMEOUT_S
    while True:
        workers = cluster.client.scheduler_info(n_workers=-1)["workers"]
        if any(worker["resources"].get(cluster.resource) for worker in workers.values()):
            return
        if workers and cluster.refused.keys() >= workers.keys():
            address_, reason = next(iter(cluster.refused.items()))
            raise ClusterUnusable(f"no worker of {address} is suitable; {address_}: {reason}")
        if time.monotonic() > end:
            raise ClusterUnusable(f"no worker joined {address} within {FIRST_WORKER_TIMEOUT_S:g} s")
        time.sleep(0.1)


def _forgotten(client: Client, plugin: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # The cluster may be gone by now.
        client.unregister_worker_plugin(plugin)


def _result(future: Future) -> CellResult:
    try:
        return future.result()
    except KilledWorker as error:
        return CellResult("lost", 0, f"the workers that ran it died: {error}", 0.0)
    except (OSError, asyncio.CancelledError) as error:
        return CellResult("lost", 0, f"the cluster lost it: {error}", 0.0)


def _versions() -> dict[str, str]:
    return library_versions() | {"python": platform.python_version(), "machine": platform.machine()}


def _short(version: str) -> str:
    return version[:12]


def _holds(file: Path, content: str) -> bool:
    try:
        return file.read_text() == content
    except OSError:
        return False
