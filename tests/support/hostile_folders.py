"""Folders of studies that were damaged, or made to harm: one change each, of a whole copy."""

import io
import json
import os
import re
import shutil

from rcac_experiments.sweeps._chunk_files import INTEGERS, KEY, NUMBERS, decode, encode
from rcac_experiments.sweeps._directory import MARK, ZEROS, sealed
from rcac_experiments.sweeps._folder import Folder


def sealed_again(data):
    """Bytes that were edited by somebody who computes their digest anew."""
    return sealed(re.sub(MARK + rb"[0-9a-f]{32}", MARK + ZEROS, data))


def chunk_of(folder, rng):
    files = sorted((folder / "chunks").glob("0*.parquet"))
    return files[rng.randrange(len(files))]


def footer_of(data):
    return len(data) - 8 - int.from_bytes(data[-8:-4], "little")


def changed_bits(path, rng, first=0, last=None):
    data = bytearray(path.read_bytes())
    last = len(data) if last is None else last
    for _ in range(rng.choice([1, 1, 1, 2, 4, 50])):
        data[rng.randrange(first, last)] ^= 1 << rng.randrange(8)
    path.write_bytes(data)


def bits(folder, rng, victim):
    changed_bits(chunk_of(folder, rng), rng)


def bits_of_pages(folder, rng, victim):
    path = chunk_of(folder, rng)
    changed_bits(path, rng, 4, footer_of(path.read_bytes()))


def bits_of_the_footer(folder, rng, victim):
    path = chunk_of(folder, rng)
    changed_bits(path, rng, footer_of(path.read_bytes()))


def bytes_of_the_footer(folder, rng, victim):
    path = chunk_of(folder, rng)
    data = bytearray(path.read_bytes())
    first = footer_of(data)
    for _ in range(rng.randint(1, 4)):
        data[rng.randrange(first, len(data))] = rng.randrange(256)
    path.write_bytes(data)


def bits_of_the_study(folder, rng, victim):
    changed_bits(folder / "study.json", rng)


def truncated(folder, rng, victim):
    path = rng.choice([chunk_of(folder, rng), folder / "study.json"])
    data = path.read_bytes()
    path.write_bytes(data[: rng.randrange(len(data))])


def overwritten(folder, rng, victim):
    path = chunk_of(folder, rng)
    data = bytearray(path.read_bytes())
    start = rng.randrange(len(data))
    length = min(rng.choice([8, 200, 4096]), len(data) - start)
    source = rng.randrange(len(data) - length + 1)
    data[start : start + length] = rng.choice(
        [bytes(length), rng.randbytes(length), data[source : source + length]]
    )
    path.write_bytes(data)


def swapped(folder, rng, victim):
    one, other = rng.sample(sorted((folder / "chunks").glob("0*.parquet")), 2)
    one.write_bytes(other.read_bytes())


def of_another_study(folder, rng, victim):
    path = chunk_of(folder, rng)
    data = path.read_bytes()
    with Folder(folder) as store:
        name = store.study.name.encode()
    path.write_bytes(sealed_again(data.replace(name, name[::-1])))


def link_to_a_chunk(folder, rng, victim):
    path = chunk_of(folder, rng)
    shutil.move(path, folder / "aside.parquet")
    path.symlink_to(folder / "aside.parquet")


def replaced_by(make):
    def change(folder, rng, victim):
        path = rng.choice([chunk_of(folder, rng), folder / "study.json"])
        path.unlink()
        make(path, victim)

    return change


def chunks_elsewhere(folder, rng, victim):
    moved = victim.parent / f"chunks{rng.randrange(10**9)}"
    shutil.move(folder / "chunks", moved)
    (folder / "chunks").symlink_to(moved)


def hole(path, victim):
    with path.open("wb") as file:
        file.truncate(10**12)


def small_hole(path, victim):
    with path.open("wb") as file:
        file.truncate(2**27)


def other_file(make):
    """A file that pyarrow reads, of another shape, with what a stranger may write in the footer."""

    def change(folder, rng, victim):
        from pyarrow import parquet

        path = chunk_of(folder, rng)
        table = parquet.read_table(path)
        about = json.loads(parquet.ParquetFile(path).metadata.metadata[KEY.encode()])
        table, options = make(table)
        out = io.BytesIO()
        with parquet.ParquetWriter(out, table.schema, store_schema=False, **options) as writer:
            writer.write_table(table, row_group_size=10**9)
            about["digest"] = ZEROS.decode()
            writer.add_key_value_metadata({KEY: json.dumps(about)})
        path.write_bytes(sealed(out.getvalue()))

    return change


def without_a_column(table):
    return table.drop_columns([table.column_names[-1]]), {}


def with_a_column(table):
    return table.append_column("more", table.column(0)), {}


def in_float32(table):
    i = table.column_names.index("rms")
    return table.set_column(i, "rms", table["rms"].cast("float32")), {}


def of_many_rows(table):
    import pyarrow

    columns = [pyarrow.nulls(2 * 10**6, field.type) for field in table.schema]
    return pyarrow.table(columns, schema=table.schema.remove_metadata()), {"compression": "zstd"}


def of_claimed_rows(folder, rng, victim):
    """10^9 rows in the footer, whatever the pages hold."""
    path = chunk_of(folder, rng)
    data = path.read_bytes()
    with Folder(folder) as store:
        first, last = store.study.plan.chunk(int(path.stem))
    foot = footer_of(data)
    tail = data[foot:-8].replace(varint(last - first + 1), varint(10**9))
    path.write_bytes(sealed_again(data[:foot] + tail + len(tail).to_bytes(4, "little") + b"PAR1"))


def varint(number):
    number, out = 2 * number, b""  # zigzag
    while number > 127:
        out, number = out + bytes([number & 127 | 128]), number >> 7
    return out + bytes([number])


def bomb(size, **options):
    def make(table):
        i = table.column_names.index("failure")
        return table.set_column(i, "failure", [["a" * size] * table.num_rows]), options

    return other_file(make)


def with_digests(edit):
    """Columns edited by somebody who computes every digest anew."""

    def change(folder, rng, victim):
        from pyarrow import parquet

        with Folder(folder) as store:
            path = chunk_of(folder, rng)
            number = int(path.stem)
            first, last = store.study.plan.chunk(number)
            layout = store.layout(number)
            columns = decode(layout, number, last - first + 1, path.read_bytes())
            signals = parquet.read_table(path, columns=layout.of(NUMBERS, INTEGERS)).to_pydict()
            path.write_bytes(sealed(encode(layout, number, edit({**columns, **signals}))))

    return change


def study_with_digest(edit):
    """study.json edited by somebody who computes its digest anew."""

    def change(folder, rng, victim):
        document = json.loads((folder / "study.json").read_bytes())
        edit(document)
        raw_study(document)(folder, rng, victim)

    return change


def raw_study(document):
    """Any text, or data, with a right digest."""

    def change(folder, rng, victim):
        text = document
        if not isinstance(text, str):
            text = json.dumps({**document, "digest": ZEROS.decode()})
        (folder / "study.json").write_bytes(sealed(text.encode()))

    return change


def repetitions(document):
    document["study"]["repetitions"] = document["stages"][-1][1] = 10**15


def escaping(document):
    document["study"]["keep_signals"] = ["../../notes.txt"]


def a_measure_that_escapes(document):
    document["study"]["keep"][0]["name"] = "../../notes"


def a_function(document):
    document["study"]["base"] = {"function": "antigravity:fly", "source": ""}


DAMAGE = (bits, bits_of_pages, bits_of_the_footer, bytes_of_the_footer, bits_of_the_study,
          truncated, overwritten)  # fmt: skip
END = f'"digest": "{ZEROS.decode()}"}}'
HOSTILE = {
    "a chunk in another's place": swapped,
    "a chunk of another study": of_another_study,
    "a link to a chunk": link_to_a_chunk,
    "a link outside": replaced_by(lambda path, victim: path.symlink_to(victim)),
    "a link to nothing": replaced_by(lambda path, victim: path.symlink_to(victim.with_name("new"))),
    "a link to /dev/zero": replaced_by(lambda path, victim: path.symlink_to("/dev/zero")),
    "a hard link outside": replaced_by(lambda path, victim: path.hardlink_to(victim)),
    "a pipe": replaced_by(lambda path, victim: os.mkfifo(path)),
    "a folder": replaced_by(lambda path, victim: path.mkdir()),
    "chunks that are a link outside": chunks_elsewhere,
    "a hole of 10^12 bytes": replaced_by(hole),
    "a hole of 10^8 bytes": replaced_by(small_hole),
    "a column missing": other_file(without_a_column),
    "a column too many": other_file(with_a_column),
    "a column in float32": other_file(in_float32),
    "2*10^6 rows in zstd": other_file(of_many_rows),
    "10^9 claimed rows": of_claimed_rows,
    "a text of 5 MB in each row, in zstd": bomb(5_000_000, compression="zstd"),
    "a text of 0.9 MB in each row, by dictionary": bomb(900_000, compression="none"),
    "a text of 20 MB in each row, by dictionary": bomb(2 * 10**7, compression="zstd"),
    "other runs, right digest": with_digests(lambda c: {**c, "run": c["run"] + 1}),
    "other coordinates, right digest": with_digests(lambda c: {**c, "R_theta": c["R_theta"] * 2}),
    "a failure with a number, right digest": with_digests(
        lambda c: {**c, "outcome": ["timed out"] * len(c["run"])}
    ),
    "10^15 repetitions": study_with_digest(repetitions),
    "a chunk of 10^9 runs": study_with_digest(lambda d: d.update(chunk_size=10**9)),
    "no stage": study_with_digest(lambda d: d.update(stages=[])),
    "a signal's name that leads out": study_with_digest(escaping),
    "a measure's name that leads out": study_with_digest(a_measure_that_escapes),
    "a function of its own": study_with_digest(a_function),
    "3*10^7 characters of numbers": raw_study({"a": [1.25] * (5 * 10**6)}),
    "10^7 lists": raw_study({"a": [[]] * 10**7}),
    "10^5 brackets": raw_study(f'{{"a": {"[" * 10**5 + "]" * 10**5}, {END}'),
    "a number of 10^6 digits": raw_study(f'{{"a": {"9" * 10**6}, {END}'),
    "nothing in study.json": raw_study({}),
}  # fmt: skip
