import multiprocessing
import subprocess
import sys
import threading
import time
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import pytest

from wzviewer.core import messages as m
from wzviewer.worker import transport
from wzviewer.worker.transport import NUM_SLOTS, SLOT_BYTES, Channel, TransportError, make_memory


@pytest.fixture
def pair():
    a, b = multiprocessing.get_context("spawn").Pipe(duplex=True)
    forth, back = make_memory()
    yield Channel(a, forth, back), Channel(b, back, forth)
    for pipe in (a, b):
        pipe.close()
    for memory in (forth, back):
        memory.close()
        memory.unlink()


@pytest.mark.skipif(sys.platform == "win32", reason="no tracker, and no signals")
def test_an_app_that_is_killed_at_once_frees_its_slots_and_says_nothing():
    code = "from wzviewer.worker.transport import make_memory as make\n"
    code += "made = make(); print(made[0].name, flush=True); input()"
    pipes = {name: subprocess.PIPE for name in ("stdin", "stdout", "stderr")}
    with subprocess.Popen([sys.executable, "-c", code], text=True, **pipes) as app:
        name = app.stdout.readline().strip()
        app.kill()
        assert app.communicate(timeout=20)[1] == ""  # the tracker holds the other end until it has ended
    with pytest.raises(FileNotFoundError):
        SharedMemory(name)


def drain(receiver, sender, count, limit_s=20.0):
    deliveries, deadline = [], time.perf_counter() + limit_s
    while len(deliveries) < count and time.perf_counter() < deadline:
        deliveries += receiver.poll(0.01)
        if sender is not receiver:
            list(sender.poll(0.01))
    return deliveries


def test_messages_and_arrays_arrive_whole_and_in_order(pair):
    sender, receiver = pair
    rng = np.random.default_rng(0)
    big = rng.random((3, SLOT_BYTES // 8), dtype=np.float32)
    sender.send(m.Heartbeat("one"))
    sender.send(
        m.ReconstructScene(7, 3), {"image": rng.integers(0, 255, (5, 6, 3), dtype=np.uint8), "big": big}
    )
    sender.send(m.Heartbeat("two"), {"empty": np.zeros((0, 3), np.float32)})
    one, scene, two = drain(receiver, sender, 3)
    assert (one.message, two.message) == (m.Heartbeat("one"), m.Heartbeat("two"))
    assert scene.message == m.ReconstructScene(7, 3)
    np.testing.assert_array_equal(scene.arrays["big"], big)
    assert scene.arrays["image"].shape == (5, 6, 3)
    assert two.arrays["empty"].shape == (0, 3)


def test_a_sender_waits_for_credits(pair):
    sender, receiver = pair
    sender.send(m.Heartbeat(), {"a": np.zeros((NUM_SLOTS + 3) * SLOT_BYTES, np.uint8)})
    assert not sender.pump()  # all slots are full, and nobody reads
    (delivery,) = drain(receiver, sender, 1)
    assert delivery.arrays["a"].nbytes == (NUM_SLOTS + 3) * SLOT_BYTES
    assert sender.pump()


def test_what_is_done_with_a_delivery_counts_against_the_time_of_a_poll(pair, monkeypatch):
    sender, receiver = pair
    for name in "abcdef":
        sender.send(m.Heartbeat(name))
    clock_s = [0.0]
    monkeypatch.setattr(transport.time, "perf_counter", lambda: clock_s[0])
    frames = []
    for _ in range(3):
        frames.append("")
        for delivery in receiver.poll(1.0):
            frames[-1] += delivery.message.stage
            clock_s[0] += 0.6
    assert frames == ["ab", "cd", "ef"]


def test_both_directions_at_once(pair):
    left, right = pair
    array = np.arange(9 * SLOT_BYTES // 4, dtype=np.int32)
    results = []

    def serve():
        right.send(m.Heartbeat("right"), {"a": array})
        results.extend(drain(right, right, 1))
        while not right.pump():
            list(right.poll(0.01))

    thread = threading.Thread(target=serve)
    thread.start()
    left.send(m.Heartbeat("left"), {"a": array})
    results += drain(left, left, 1)
    deadline = time.perf_counter() + 20
    while thread.is_alive() and time.perf_counter() < deadline:
        list(left.poll(0.01))
    thread.join(1)
    assert sorted(d.message.stage for d in results) == ["left", "right"]
    for delivery in results:
        np.testing.assert_array_equal(delivery.arrays["a"], array)


@pytest.mark.parametrize(
    "frame",
    [
        b"X{}",
        b"M{",
        b'M{"message":{"type":"Nope"},"arrays":[]}',
        b'M{"message":{"type":"Heartbeat"},"arrays":[["a","|O",[1]]]}',
        b'M{"message":{"type":"Heartbeat"},"arrays":[["a","<f8",[9999999999999]]]}',
        b'M{"message":{"type":"Heartbeat"},"arrays":[["a","<f8",[-1]]]}',
        b'P{"slot":0,"bytes":4,"crc":0}',
    ],
)
def test_frames_that_break_the_protocol_are_refused(pair, frame):
    sender, receiver = pair
    sender.pipe.send_bytes(frame)
    with pytest.raises(TransportError):
        receiver.receive()


def test_a_damaged_piece_is_refused(pair):
    sender, receiver = pair
    sender.send(m.Heartbeat(), {"a": np.arange(100, dtype=np.int32)})
    sender._outgoing.buf[5] ^= 1
    receiver.receive()
    with pytest.raises(TransportError, match="damaged"):
        receiver.receive()


def test_the_other_side_being_gone_is_an_eof(pair):
    sender, receiver = pair
    sender.pipe.close()
    with pytest.raises(EOFError):
        receiver.receive()
