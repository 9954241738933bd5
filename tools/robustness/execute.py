# SPDX-License-Identifier: MIT
"""Runs of a campaign on a Dask cluster: that of the local cores, or a given one."""

import contextlib
import itertools
import logging
import os
import signal
import threading

import cloudpickle
from dask.distributed import (CancelledError, Client, KilledWorker, LocalCluster,
                              as_completed)

from . import results, simulator, worker
from .campaign import CampaignError

IN_FLIGHT = 4  # runs for each thread: none waits for work, and Ctrl-C has little to drop
CONNECT_S = 10

cloudpickle.register_pickle_by_value(worker)


class Portable:
    """A function that arrives at workers as its code; they need no files of the tools.

    Dask by itself sends the name of its module.
    """

    def __init__(self, function):
        self.function = function

    def __call__(self, *arguments):
        return self.function(*arguments)

    def __reduce__(self):
        return cloudpickle.loads, (cloudpickle.dumps(self.function),)


def local_cluster(jobs):
    """Threads of this process suffice, as each does nothing but wait for a simulator."""
    return LocalCluster(n_workers=1, threads_per_worker=jobs or len(os.sched_getaffinity(0)),
                        processes=False, dashboard_address=None, silence_logs=logging.CRITICAL)


@contextlib.contextmanager
def client_of(scheduler, jobs):
    for name in ("distributed", "asyncio"):  # one line of ours says it; asyncio tells late of connections that Dask has given up
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            yield stack.enter_context(Client(stack.enter_context(local_cluster(jobs))))
            return
        try:
            client = Client(scheduler, timeout=CONNECT_S)
        except (OSError, ValueError) as error:
            raise CampaignError(f"--scheduler: {scheduler}: {first_line(error)}; expected the "
                                "address of a Dask scheduler, for instance tcp://host:8786") from error
        yield stack.enter_context(client)


def first_line(error):
    return str(error).partition("\n")[0] or type(error).__name__


def threads_of(client):
    count = sum(client.nthreads().values())
    if count == 0:
        raise CampaignError("--scheduler: it has no workers; expected at least one: dask worker "
                            "ADDRESS")
    return count


def completed(client, tasks):
    """The results of all tasks (function and arguments), as they come."""
    def submit(task):
        return client.submit(*task, pure=False, retries=0)

    waiting = iter(tasks)
    first = itertools.islice(waiting, IN_FLIGHT * threads_of(client))
    flow = as_completed([submit(task) for task in first])
    for future in flow:
        yield future.result()
        for task in itertools.islice(waiting, 1):
            flow.add(submit(task))


@contextlib.contextmanager
def noted_interrupt():
    """An event that the first Ctrl-C sets. Raised within Dask, an interrupt may leave a lock held, for which the end then waits
    for ever. The second Ctrl-C is raised."""
    noted, before = threading.Event(), signal.getsignal(signal.SIGINT)

    def note(*_):
        noted.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, note)
    try:
        yield noted
    finally:
        signal.signal(signal.SIGINT, before)


def execute(campaign, program, runs, store, scheduler, jobs, progress):
    """Runs those of `runs` and stores a row each; `progress(row)` after each. Raises KeyboardInterrupt behind the run that ends
    next after a Ctrl-C. Call it in the main thread."""
    data = simulator.data_files(campaign)
    expected = simulator.fingerprint(program, campaign)
    values, function = {}, Portable(worker.simulate)

    def tasks():
        for run in runs:
            values[run] = campaign.values(run)
            command = [*program.command(campaign, values[run]), "--json", "-"]
            yield function, run, command, data, expected

    with noted_interrupt() as interrupt, client_of(scheduler, jobs) as client:
        try:
            for run, status, output, message in completed(client, tasks()):
                metrics = simulator.result_of(campaign, status, output, f"run {run}: {message}")
                row = results.row_of(run, simulator.outcome(metrics), values.pop(run), metrics)
                store.add(row)
                progress(row)
                if interrupt.is_set():
                    raise KeyboardInterrupt
        except (OSError, RuntimeError, KilledWorker, CancelledError) as error:
            raise CampaignError(f"a worker: {first_line(error)}; expected workers that last, with "
                                "the same simulator and data files; the same command goes on"
                                ) from error
