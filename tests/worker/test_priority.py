"""A worker beside frames leaves them the cores; one on the command line does not."""

import os
import sys

import pytest

from wzviewer.worker.client import WorkerClient, WorkerStarted


@pytest.mark.skipif(sys.platform != "linux", reason="asks the Linux scheduler")
@pytest.mark.parametrize("yields", [False, True])
def test_the_worker_of_the_app_waits_for_frames(yields):
    client = WorkerClient(yields=yields)
    client.start()
    try:
        for _ in range(3000):
            if any(isinstance(event, WorkerStarted) for event in client.poll(0.05)):
                break
            client.channel_wait(0.05)
        threads = [int(name) for name in os.listdir(f"/proc/{client.pid}/task")]
        assert len(threads) > 1
        # All of them: those that importing numpy starts come before the first line of the worker.
        assert {os.sched_getscheduler(t) for t in threads} == {os.SCHED_IDLE if yields else os.SCHED_OTHER}
    finally:
        client.close()
