"""The rows of a chunk as a Parquet file, and back: what is read is what was written, or refused.

Without a codec, with checksums of pages, and with a digest of the values in the metadata of the
file, which binds them to their study and chunk. pyarrow alone would read one file in two with a
flipped bit as another table.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

import numpy as np

from compensator_theory.libraries import needed

MOST_BYTES = 2**28  # of a chunk's file, as of any file that is read
MOST_TEXT = 2**26  # characters in the rows of a chunk
# What a footer may hold, in bytes of a text and in entries of a list.
FOOTER = {"thrift_string_size_limit": 2**20, "thrift_container_size_limit": 2**16}
KEY = b"rcac"  # in the file's metadata
TEXT, INTEGER, NUMBER, TRUTH, NUMBERS, INTEGERS = (
    "text", "integer", "number", "truth", "numbers", "integers",
)  # fmt: skip
Columns = dict[str, Any]  # arrays of numbers, lists of texts, lists of arrays


class Damaged(Exception):
    """A file is not what was written; why."""


@dataclass(frozen=True)
class Layout:
    """The columns of a chunk and their kinds, and the study that it is bound to."""

    study: str
    columns: tuple[tuple[str, str], ...]

    @property
    def texts(self) -> list[str]:
        """The columns of texts."""
        return [name for name, kind in self.columns if kind == TEXT]

    def schema(self, arrow: Any, of_texts: Any) -> Any:
        """That of the file."""
        types = {
            TEXT: of_texts, INTEGER: arrow.int64(), NUMBER: arrow.float64(),
            TRUTH: arrow.bool_(), NUMBERS: arrow.list_(arrow.float64()),
            INTEGERS: arrow.list_(arrow.int64()),
        }  # fmt: skip
        return arrow.schema([(name, types[kind]) for name, kind in self.columns])


def encode(layout: Layout, number: int, columns: Mapping[str, Sequence[Any]]) -> bytes:
    """The file of a chunk; a None is a null, and so is a number that is NaN.

    Examples
    --------
    >>> from rcac_experiments.sweeps._chunk_files import Layout, decode, encode
    >>> layout = Layout("a study", (("run", "integer"), ("rms", "number"), ("why", "text")))
    >>> data = encode(layout, 1, {"run": [0, 1], "rms": [0.5, None], "why": ["", "a worker died"]})
    >>> decode(layout, 1, 2, data)["why"]
    ['', 'a worker died']
    """
    arrow, parquet = _libraries()
    schema = layout.schema(arrow, arrow.string())
    arrays = [
        arrow.array(columns[name], type=schema.field(i).type, from_pandas=kind == NUMBER)
        for i, (name, kind) in enumerate(layout.columns)
    ]
    table = arrow.Table.from_arrays(arrays, schema=schema)
    _, found = _values(layout, number, table)
    about = json.dumps({"study": layout.study, "chunk": number, "digest": found})
    out = arrow.BufferOutputStream()
    with parquet.ParquetWriter(
        out, schema, compression="none", write_page_checksum=True, write_statistics=False,
        use_dictionary=layout.texts, store_schema=False,
    ) as writer:  # fmt: skip
        writer.write_table(table)
        writer.add_key_value_metadata({KEY.decode(): about})  # that of the schema is not written
    data = out.getvalue().to_pybytes()
    if len(data) > MOST_BYTES:
        raise Damaged(f"it would have {len(data)} bytes, and at most {MOST_BYTES} are read")
    return bytes(data)


def decode(layout: Layout, number: int, rows: int, data: bytes) -> Columns:
    """The columns of a chunk of so many rows; raises `Damaged` for whatever else the bytes are.

    Numbers come as arrays, NaN where there is none; sizes of columns and their codec are not
    looked at, since pyarrow ends the process where their statistics are malformed.
    """
    arrow, parquet = _libraries()
    try:
        file = parquet.ParquetFile(
            arrow.BufferReader(data), page_checksum_verification=True,
            read_dictionary=layout.texts, **FOOTER,
        )  # fmt: skip
        about = file.metadata
        if about.num_rows != rows or about.num_row_groups != 1:
            raise Damaged(f"it has {about.num_rows} rows and not {rows}")
        schema = layout.schema(arrow, arrow.dictionary(arrow.int32(), arrow.string()))
        if not file.schema_arrow.remove_metadata().equals(schema):
            raise Damaged("it has other columns")
        table = file.read(use_threads=False)
        columns, found = _values(layout, number, table)
        expected = {"study": layout.study, "chunk": number, "digest": found}
        if table.num_rows != rows or json.loads(about.metadata[KEY]) != expected:
            raise Damaged("it is not what was written, or belongs to another study or chunk")
    except Damaged:
        raise
    except Exception as error:  # whatever pyarrow says of bytes that are none of its own
        raise Damaged(f"it cannot be read ({type(error).__name__})") from None
    return columns


def _values(layout: Layout, number: int, table: Any) -> tuple[Columns, str]:
    """The columns as they are used here, and the digest of all values and nulls.

    Arrow's own buffers are no canonical bytes: they differ in padding and in masks left out.
    """
    found = blake2b(digest_size=16)
    head = [layout.study, number, layout.columns, table.num_rows]
    found.update(json.dumps(head).encode())
    columns: Columns = {}
    characters = 0
    for (name, kind), chunked in zip(layout.columns, table.columns, strict=True):
        array = chunked.combine_chunks()
        missing = np.asarray(array.is_null())
        found.update(missing.tobytes())
        if kind == TEXT:
            texts = _texts(array)
            characters += sum(len(text) for text in texts if text is not None)
            if characters > MOST_TEXT:
                raise Damaged(f"it has texts of more than {MOST_TEXT} characters")
            found.update(json.dumps(texts).encode())
            columns[name] = texts
        elif kind in (NUMBERS, INTEGERS):
            sizes = np.asarray(array.value_lengths().fill_null(0), dtype=np.int64)
            flat = array.flatten()
            if flat.null_count:
                raise Damaged("a signal has a hole")
            numbers = np.asarray(flat.to_numpy(zero_copy_only=False))
            found.update(sizes.tobytes() + numbers.tobytes())
            pieces = np.split(numbers, np.cumsum(sizes)[:-1])
            columns[name] = [
                None if none else piece for none, piece in zip(missing, pieces, strict=True)
            ]
        else:
            empty = False if kind == TRUTH else 0
            numbers = np.asarray(array.fill_null(empty).to_numpy(zero_copy_only=False))
            found.update(numbers.tobytes())
            if kind == NUMBER:
                numbers = np.where(missing, np.nan, numbers)
            elif missing.any():
                raise Damaged(f"{name} has a hole")
            columns[name] = numbers
    return columns, found.hexdigest()


def _texts(array: Any) -> list[str | None]:
    """The texts of a column, each of them held once."""
    if not hasattr(array, "dictionary"):
        return list(array.to_pylist())
    words, places = array.dictionary.to_pylist(), array.indices.to_pylist()
    return [None if place is None else words[place] for place in places]


def _libraries() -> tuple[Any, Any]:
    with needed("pyarrow"):
        import pyarrow
        import pyarrow.parquet
    return pyarrow, pyarrow.parquet
