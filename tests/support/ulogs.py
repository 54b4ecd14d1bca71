"""A small writer of ULog files, by the format that PX4 documents."""

import struct

import numpy as np

TYPES = {"float32": "float", "float64": "double", "uint64": "uint64_t", "int32": "int32_t",
         "uint8": "uint8_t"}  # fmt: skip


def _message(kind, data):
    return struct.pack("<HB", len(data), ord(kind)) + data


def ulog(topics, dropouts=()):
    """The bytes of a log: topics from name to fields by name, each with `timestamp` in us.

    A field of shape (rows, width) is an array; `dropouts` are durations in ms.
    """
    out = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0), _message("B", bytes(40))]
    added, rows = [], []
    for number, (name, fields) in enumerate(topics.items()):
        columns = {key: np.asarray(value) for key, value in fields.items()}
        columns["timestamp"] = columns["timestamp"].astype(np.uint64)
        columns = {"timestamp": columns.pop("timestamp"), **columns}
        form = ";".join(
            TYPES[v.dtype.name] + (f"[{v.shape[1]}]" if v.ndim > 1 else "") + f" {key}"
            for key, v in columns.items()
        )
        out.append(_message("F", f"{name}:{form};".encode()))
        added.append(_message("A", struct.pack("<BH", 0, number) + name.encode()))
        for k, stamp in enumerate(columns["timestamp"].tolist()):
            data = b"".join(v[k].tobytes() for v in columns.values())
            rows.append((stamp, _message("D", struct.pack("<H", number) + data)))
    rows.sort(key=lambda row: row[0])
    lost = [_message("O", struct.pack("<H", duration)) for duration in dropouts]
    return b"".join([*out, *added, *(row for _, row in rows), *lost])
