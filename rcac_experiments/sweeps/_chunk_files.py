"""The rows of a chunk as a Parquet file, without a codec and with checksums of its pages."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from compensator_theory.libraries import needed
from rcac_experiments.sweeps._directory import ZEROS
from rcac_experiments.sweeps._problems import Damaged

MOST_BYTES = 2**28  # of a chunk's file, as of any file that is read
MOST_TEXT = 2**26  # characters of the texts of a column
# What a footer may hold, in bytes of a text and in entries of a list.
FOOTER = {"thrift_string_size_limit": 2**20, "thrift_container_size_limit": 2**16}
KEY = "rcac"  # in the file's metadata
TEXT, INTEGER, NUMBER, TRUTH, NUMBERS, INTEGERS = (
    "text", "integer", "number", "truth", "numbers", "integers",
)  # fmt: skip
Columns = dict[str, Any]  # arrays of numbers, lists of texts


@dataclass(frozen=True)
class Layout:
    """The columns of a chunk and their kinds, and the study that it is bound to."""

    study: str
    columns: tuple[tuple[str, str], ...]

    def of(self, *kinds: str) -> list[str]:
        """The columns of some kinds."""
        return [name for name, kind in self.columns if kind in kinds]

    def schema(self, arrow: Any, of_texts: Any) -> Any:
        """That of the file."""
        types = {
            TEXT: of_texts, INTEGER: arrow.int64(), NUMBER: arrow.float64(),
            TRUTH: arrow.bool_(), NUMBERS: arrow.list_(arrow.float64()),
            INTEGERS: arrow.list_(arrow.int64()),
        }  # fmt: skip
        return arrow.schema([(name, types[kind]) for name, kind in self.columns])


def encode(layout: Layout, number: int, columns: Mapping[str, Sequence[Any]]) -> bytes:
    """The file of a chunk, not sealed yet; a None is a null, and so is a number that is NaN."""
    arrow, parquet = _libraries()
    schema = layout.schema(arrow, arrow.string())
    arrays = [
        arrow.array(columns[name], type=schema.field(i).type, from_pandas=kind == NUMBER)
        for i, (name, kind) in enumerate(layout.columns)
    ]
    out = arrow.BufferOutputStream()
    with parquet.ParquetWriter(
        out, schema, compression="none", write_page_checksum=True, write_statistics=False,
        use_dictionary=layout.of(TEXT), store_schema=False,
    ) as writer:  # fmt: skip
        writer.write_table(arrow.Table.from_arrays(arrays, schema=schema))
        about = json.dumps({"study": layout.study, "chunk": number, "digest": ZEROS.decode()})
        writer.add_key_value_metadata({KEY: about})  # that of the schema is not written
    data = bytes(out.getvalue().to_pybytes())
    if len(data) > MOST_BYTES:
        raise Damaged(f"it would have {len(data)} bytes, and at most {MOST_BYTES} are read")
    return data


def decode(layout: Layout, number: int, rows: int, data: bytes) -> Columns:
    """The columns of a chunk of so many rows but for signals; `Damaged` for all that is none.

    Sizes of columns and their codec are not looked at, since pyarrow ends the process where their
    statistics are malformed.
    """
    arrow, parquet = _libraries()
    try:
        file = parquet.ParquetFile(
            arrow.BufferReader(data), read_dictionary=layout.of(TEXT), **FOOTER
        )
        about = file.metadata
        if about.num_rows != rows or about.num_row_groups != 1:
            raise Damaged(f"it has {about.num_rows} rows and not {rows}")
        schema = layout.schema(arrow, arrow.dictionary(arrow.int32(), arrow.string()))
        if not file.schema_arrow.remove_metadata().equals(schema):
            raise Damaged("it has other columns")
        bound = json.loads(about.metadata[KEY.encode()])
        if (bound["study"], bound["chunk"]) != (layout.study, number):
            raise Damaged("it belongs to another study or chunk")
        table = file.read(layout.of(TEXT, INTEGER, NUMBER, TRUTH), use_threads=False)
        if table.num_rows != rows:
            raise Damaged(f"it has {table.num_rows} rows and not {rows}")
        kinds = dict(layout.columns)
        return {name: _column(kinds[name], table[name]) for name in table.column_names}
    except Damaged:
        raise
    except Exception as error:  # whatever pyarrow says of bytes that are none of its own
        raise Damaged(f"it cannot be read ({type(error).__name__})") from None


def _column(kind: str, chunked: Any) -> Any:
    """An array of numbers, NaN where there is none; a list of texts, each stored once."""
    array = chunked.combine_chunks()
    if kind == TEXT:
        words = array.dictionary.to_pylist()
        if sum(len(word or "") for word in words) > MOST_TEXT:
            raise Damaged(f"it has texts of more than {MOST_TEXT} characters")
        places = array.indices.to_pylist()
        return [None if place is None else words[place] for place in places]
    if kind != NUMBER and array.null_count:
        raise Damaged("a column has a hole")
    return np.asarray(array.to_numpy(zero_copy_only=False))


def _libraries() -> tuple[Any, Any]:
    with needed("pyarrow"):
        import pyarrow
        import pyarrow.parquet
    return pyarrow, pyarrow.parquet
