"""The client against workers that misbehave; the real worker is in test_process."""

import sys
import threading
import time
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import pytest

from tests.worker import children
from wzviewer.worker import client as client_module
from wzviewer.worker.client import LevelDropped, WorkerClient, WorkerLost, WorkerStarted, wait_for_import

PHOTO = np.zeros((48, 64, 3), np.uint8)


def poll_for(client, kind, limit_s=20.0):
    events, deadline = [], time.perf_counter() + limit_s
    while time.perf_counter() < deadline:
        events += client.poll(0.01)
        if any(isinstance(e, kind) for e in events):
            return [e for e in events if isinstance(e, kind)]
        client.channel_wait(0.02)
    raise AssertionError(f"no {kind.__name__} among {events}")


@pytest.fixture
def make_client():
    clients = []

    def make(entry):
        clients.append(WorkerClient(entry=entry))
        clients[-1].start()
        return clients[-1]

    yield make
    for client in clients:
        client.close()


def test_a_worker_without_a_sign_of_life_is_replaced(make_client, monkeypatch):
    monkeypatch.setattr(client_module, "START_LIMIT_S", 0.5)
    client = make_client(children.silent)
    first = client.pid
    (lost,) = poll_for(client, WorkerLost)
    assert "no sign of life" in lost.why
    assert client.pid != first


def test_a_laptop_that_slept_does_not_make_the_worker_look_hung(make_client, monkeypatch):
    monkeypatch.setattr(client_module, "START_LIMIT_S", 1.0)
    monkeypatch.setattr(client_module, "LONGEST_GAP_S", 0.1)
    client = make_client(children.silent)
    client.poll(0.01)
    time.sleep(1.5)  # nobody polls: both sides stood still
    assert not client.poll(0.01)


def test_slots_have_no_name_once_the_worker_holds_them(make_client):
    client = make_client(children.deaf)
    names = [memory.name for memory in client._memory]
    poll_for(client, WorkerStarted)
    for name in names:  # so that nothing is left behind, and nothing complains, when the app is killed
        with pytest.raises(FileNotFoundError):
            SharedMemory(name)


def test_a_worker_that_breaks_the_protocol_is_replaced(make_client):
    (lost,) = poll_for(make_client(children.rude), WorkerLost)
    assert "protocol" in lost.why


def test_a_worker_that_ends_is_replaced_and_the_request_dropped_with_a_reason(make_client):
    client = make_client(children.brittle)
    request_id = client.reconstruct(PHOTO)
    (dropped,) = poll_for(client, LevelDropped)
    assert dropped.request_id == request_id
    assert "status 9" in dropped.why
    assert not client.is_busy


def test_a_cancel_that_is_not_heard_ends_the_worker_within_a_second(make_client):
    client = make_client(children.deaf)
    poll_for(client, WorkerStarted)
    client.reconstruct(PHOTO)
    start_s = time.perf_counter()
    client.cancel()
    events = []
    while not any(isinstance(e, WorkerLost) for e in events):
        events += client.poll(0.01)
    (dropped,) = [e for e in events if isinstance(e, LevelDropped)]
    assert dropped.cancelled
    assert events[-1].is_after_cancel  # nobody need be told: it was asked for
    assert time.perf_counter() - start_s < 1.0  # measured 0.71 s, 0.7 s of them the grace
    assert not client.is_busy


def test_where_another_request_waits_the_worker_is_given_time_to_stop(make_client):
    client = make_client(children.deaf)
    poll_for(client, WorkerStarted)
    client.reconstruct(PHOTO)
    pid = client.pid
    client.cancel(client_module.PATIENT_S)
    deadline = time.perf_counter() + 1.2 * client_module.CANCEL_GRACE_S
    while time.perf_counter() < deadline:
        assert client.poll(0.01) == []
    assert client.pid == pid


def test_a_worker_that_never_starts_is_given_up_and_tried_again_when_asked(make_client):
    client = make_client(children.brittle)
    lost, deadline = [], time.perf_counter() + 30
    while client.pid is not None and time.perf_counter() < deadline:
        lost += [e for e in client.poll(0.01) if isinstance(e, WorkerLost)]
        client.channel_wait(0.02)
    assert len(lost) == client_module.MAX_FAILED_STARTS
    assert "3 times in a row" in lost[-1].why
    assert client.poll(0.01) == []
    client.reconstruct(PHOTO)
    assert poll_for(client, LevelDropped)


def test_two_requests_at_once_are_refused(make_client):
    client = make_client(children.deaf)
    client.reconstruct(PHOTO)
    with pytest.raises(RuntimeError, match="running"):
        client.reconstruct(PHOTO)


def test_closing_frees_process_and_memory(make_client):
    client = make_client(children.silent)
    process, names = client._process, [memory.name for memory in client._memory]
    client.close()
    assert not process.is_alive()
    for name in names:
        with pytest.raises(FileNotFoundError):
            SharedMemory(name)


def test_a_start_waits_for_an_import_that_changes_the_path_for_a_while(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path, "/site-packages/cv2"])
    wait_for_import("cv2", limit_s=0.01)  # not for ever
    threading.Timer(0.1, sys.path.pop).start()
    wait_for_import("cv2")
    assert "/site-packages/cv2" not in sys.path
