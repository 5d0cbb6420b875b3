"""The worker of the queue of jobs, and the functions that run them."""

import importlib
import json
import logging
import threading
import time
import uuid
from collections.abc import Sequence
from dataclasses import dataclass, field

from calibdb.store.ports import JobName
from calibdb.store.sqlite import Job, SqliteJobs

TIMEOUT_S = 60.0
"""Time of one run. The functions keep to it themselves."""
PAUSES_S = (1.0, 4.0)
"""Pauses before a job that failed runs again."""
_POLL_S = 0.25  # between two looks for the jobs of other processes

_log = logging.getLogger("infra.server.jobs")


@dataclass(frozen=True)
class Context:
    """The `context` argument of a function, with Lambda's names."""

    aws_request_id: str = field(default_factory=lambda: str(uuid.uuid4()))
    end: float = field(default_factory=lambda: time.monotonic() + TIMEOUT_S)

    def get_remaining_time_in_millis(self) -> int:
        """Return the milliseconds left."""
        return max(0, round((self.end - time.monotonic()) * 1000))


def call(job: JobName, payload: bytes, context: Context) -> bytes:
    """Run the function of a job; raises what it raises."""
    handler = importlib.import_module(f"functions.{job}.app").handler
    return json.dumps(handler(json.loads(payload), context)).encode()


def run(job: JobName, payload: bytes) -> bytes | None:
    """Run the function of a job; None, and the reason in the log, if it fails."""
    try:
        return call(job, payload, Context())
    except Exception:  # noqa: BLE001 - a function may raise anything
        _log.exception("%s failed", job)
        return None


class JobWorker(threading.Thread):
    """A thread that runs queued jobs one at a time, oldest first."""

    def __init__(self, jobs: SqliteJobs, pauses_s: Sequence[float] = PAUSES_S) -> None:
        super().__init__(name="jobs", daemon=True)
        self._jobs = jobs
        self._pauses_s = pauses_s
        self._ending = threading.Event()

    def stop(self, timeout_s: float) -> None:
        """Take no more jobs, and wait for the one that is running; it runs again if that takes too long."""
        self._ending.set()
        self._jobs.queued.set()
        self.join(timeout_s)

    def run(self) -> None:
        """Work until `stop`; jobs that a process was killed at run again."""
        self._jobs.release_all()
        while not self._ending.is_set():
            try:
                job = self._jobs.take(2 * TIMEOUT_S)
                if job is not None:
                    self._run_one(job)
                    continue
            except Exception:  # noqa: BLE001 - storage that fails now may work later
                _log.exception("the queue of jobs could not be read or written")
                self._ending.wait(1.0)
            self._jobs.queued.wait(_POLL_S)
            self._jobs.queued.clear()

    def _run_one(self, job: Job) -> None:
        try:
            # The same id for every attempt: a lease of the first one is still its own.
            call(job.name, job.payload, Context(f"job-{job.id}"))
        except Exception as error:  # noqa: BLE001 - a function may raise anything
            _log.exception("%s failed (attempt %d)", job.name, job.attempts)
            if job.attempts <= len(self._pauses_s):
                self._jobs.retry(job, self._pauses_s[job.attempts - 1])
            else:
                self._jobs.fail(job, f"{type(error).__name__}: {error}")
        else:
            self._jobs.finish(job)
