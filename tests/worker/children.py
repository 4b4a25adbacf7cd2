"""Worker processes that misbehave; each is the target of a spawned process."""

import time


def silent(pipe, outgoing_name, incoming_name, synthesizer):
    """Starts, and never says a word."""
    time.sleep(60.0)


def rude(pipe, outgoing_name, incoming_name, synthesizer):
    """Breaks the protocol at once."""
    pipe.send_bytes(b"M" + b'{"message":{"type":"Nonsense"},"arrays":[]}')
    time.sleep(60.0)


def deaf(pipe, outgoing_name, incoming_name, synthesizer):
    """Is ready and alive, but works on nothing and hears no cancel."""
    from multiprocessing.shared_memory import SharedMemory

    from wzviewer.core import messages as m
    from wzviewer.worker.transport import Channel

    channel = Channel(pipe, SharedMemory(outgoing_name), SharedMemory(incoming_name))
    channel.send(m.WorkerReady(0))
    while True:
        channel.send(m.Heartbeat())
        time.sleep(0.1)


def brittle(pipe, outgoing_name, incoming_name, synthesizer):
    """Ends with an error at once."""
    raise SystemExit(9)
