from dataclasses import MISSING, fields

import pytest

from wzviewer.core import messages as m

SAMPLES = {int: 3, float: 0.5, str: "text", bool: True, m.Json: {"a": [1, 2.5]}, m.Indices: [1, 4]}


def sample(cls):
    return cls(**{f.name: SAMPLES[f.type] for f in fields(cls)})


@pytest.mark.parametrize("cls", m.MESSAGE_TYPES.values(), ids=lambda c: c.__name__)
def test_every_message_survives_the_wire(cls):
    message = sample(cls)
    assert m.decode(m.from_bytes(m.to_bytes(m.encode(message)))) == message
    assert message.direction in ("app->worker", "worker->app")


@pytest.mark.parametrize("cls", m.MESSAGE_TYPES.values(), ids=lambda c: c.__name__)
def test_fields_that_are_missing_unknown_or_mistyped_are_refused(cls):
    record = m.encode(sample(cls))
    with pytest.raises(ValueError, match="malformed"):
        m.decode({**record, "surplus": 1})
    for f in fields(cls):
        with pytest.raises(ValueError, match="malformed"):
            m.decode({**record, f.name: None})
        if f.default is MISSING and f.default_factory is MISSING:
            with pytest.raises(ValueError, match="lacks"):
                m.decode({k: v for k, v in record.items() if k != f.name})


@pytest.mark.parametrize("data", [b"", b"[]", b"{", b'"x"', b"\xff", b"{}" + b" " * (5 << 20)])
def test_bytes_that_are_no_message_are_refused(data):
    with pytest.raises(ValueError):  # noqa: PT011 - the wording is json's
        m.from_bytes(data)


def test_indices_are_whole_numbers():
    record = m.encode(sample(m.SynthesizeLevel))
    for wrong in ([1.5], [True], ["1"], "12"):
        with pytest.raises(ValueError, match="malformed"):
            m.decode({**record, "beside": wrong})


def test_an_unknown_type_is_refused():
    with pytest.raises(ValueError, match="unknown message"):
        m.decode({"type": "FormatDisk"})
