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
        assert os.sched_getscheduler(client.pid) == (os.SCHED_IDLE if yields else os.SCHED_OTHER)
    finally:
        client.close()
