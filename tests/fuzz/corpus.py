"""Cases that once broke a command, by name: what makes the files and the command, and what is said of them."""

import io
import struct
from collections.abc import Callable

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import realitygap_engines as engines
from fuzz import template
from fuzz.kinds import CHECK, NEW, SIMULATE, Case
from fuzz.template import JOINTS, SCENARIO, URDF, dumped, files, mcap

Make = Callable[[], Case]
Message = tuple[float, list[str], list[float], list[float]]
LIMIT = '<limit lower="-3.2" upper="3.2" effort="13.78" velocity="6.2"/>'
INIT = ["init", "arm.urdf"]


def urdf(old: str, new: str, *command: str) -> Make:
    """The robot with text replaced."""
    assert old in URDF
    return lambda: (files(arm__urdf=URDF.replace(old, new).encode()), list(command or CHECK))


def bag(*messages: Message) -> Make:
    """A draft of a bag of these messages."""
    return lambda: (files(run__mcap=mcap(list(messages))), [*INIT, "run.mcap", *NEW])


def mcap_file(content: Callable[[], bytes]) -> Make:
    """A draft of a MCAP file."""
    return lambda: (files(run__mcap=content()), [*INIT, "run.mcap", *NEW])


def table(content: bytes, name: str = "run.csv", command: str = "init") -> Make:
    """A draft or a check of a table."""
    scenario = SCENARIO | {"recordings": {"effort": "none", "runs": [{"path": name}]}}
    run = [*INIT, name, *NEW] if command == "init" else CHECK
    return lambda: (files(scenario__yaml=dumped(scenario)) | {name: content}, run)


def scenario(**changed: object) -> Make:
    """A check of a scenario with keys changed."""
    return lambda: (files(scenario__yaml=dumped(SCENARIO | changed)), CHECK)


def many_rows() -> bytes:
    """Sixty million rows in some kilobytes."""
    out = io.BytesIO()
    column = pa.array(np.zeros(1_000_000))
    part = pa.table(dict.fromkeys(("time", "position_shoulder", "position_elbow", "command_shoulder"), column))
    with pq.ParquetWriter(out, part.schema, compression="zstd") as writer:
        for _ in range(60):
            writer.write_table(part)
    return out.getvalue()


def bomb() -> bytes:
    """A gigabyte of zeros, packed."""
    out = pa.BufferOutputStream()
    with pa.CompressedOutputStream(out, "zstd") as packed:
        for _ in range(1024):
            packed.write(bytes(1 << 20))
    return bytes(out.getvalue())


def record(kind: int, content: bytes) -> bytes:
    """A record of MCAP."""
    return struct.pack("<BQ", kind, len(content)) + content


def words(text: bytes) -> bytes:
    """A text of MCAP."""
    return struct.pack("<I", len(text)) + text


def chunk_bomb() -> bytes:
    """A chunk of a MCAP file that unpacks to three gigabytes and says that they are a hundred bytes."""
    packed = 3 * bomb()
    chunk = struct.pack("<QQQI", 0, 1, 100, 0) + words(b"zstd") + struct.pack("<Q", len(packed)) + packed
    header, end = record(1, words(b"ros2") + words(b"")), record(2, bytes(20))
    magic = b"\x89MCAP0\r\n"
    return magic + header + record(6, chunk) + end + magic


def definition(text: bytes, language: bytes = b"ros2msg") -> bytes:
    """A MCAP file with one message of a type of this definition."""
    schema = struct.pack("<H", 1) + words(b"a/msg/B") + words(language) + words(text)
    channel = struct.pack("<HH", 1, 1) + words(b"/joint_states") + words(b"cdr") + words(b"")
    header, end = record(1, words(b"ros2") + words(b"")), record(2, bytes(20))
    magic = b"\x89MCAP0\r\n"
    message = record(5, struct.pack("<HIQQ", 1, 0, 1, 1) + bytes(8))
    return magic + header + record(3, schema) + record(4, channel) + message + end + magic


TIMES = np.arange(template.SAMPLES) * template.PERIOD
JUMPED = template.table().assign(time=np.where(TIMES < 0.3, TIMES, TIMES + 3600.0)).to_csv(index=False).encode()
NAMES = list(JOINTS)
STATES = dumped(
    SCENARIO
    | {
        "recordings": {"state": "/joint_states", "effort": "none", "runs": [{"path": "run.mcap"}]},
        "motion": {"recorded": "/joint_states"},
    }
)
ONE: Message = (1.0, NAMES, [0.0, 0.0], [])

CORPUS: dict[str, tuple[Make, str]] = {
    # numbers that no robot has
    "axis of 1e200": (urdf('xyz="0 1 0"', 'xyz="0 1e200 0"'), "expected a direction: a vector of length 1"),
    "mass of 1e30": (urdf('value="1.32"', 'value="1e30"'), "mass is 1e+30 kg, which no machine has"),
    "mass of 1e300": (urdf('value="1.32"', 'value="1e300"', *INIT, "run.csv", *NEW), "which no machine has"),
    "inertia of 1e200": (urdf('ixx="0.0036"', 'ixx="1e200"', "audit", "arm.urdf"), "which no machine has"),
    "origin of 1e200": (urdf('xyz="0 0 -0.1585"', 'xyz="0 0 1e200"'), "which no machine has"),
    "friction of 1e300": (urdf('friction="0"', 'friction="1e300"'), "which no machine has"),
    "box of 1e300": (urdf('size="0.1 0.1 0.2"', 'size="1e300 1 1"'), "which no machine has"),
    "name of 50,000 characters": (urdf('"elbow"', f'"{"e" * 50_000}"'), "has a name of 50000 characters"),
    "no room to move": (urdf('lower="-3.2" upper="3.2"', 'lower="1" upper="1"'), "expected room to move"),
    "mesh without a file": (urdf('<box size="0.1 0.1 0.2"/>', "<mesh/>", "audit", "arm.urdf"), "mesh"),
    **{
        f"limits that are not stated in {engine}": (
            urdf(LIMIT, '<limit effort="1" velocity="1"/>', "simulate", engine, "scenario.yaml"),
            "",  # an outcome, whichever
        )
        for engine in engines.available()
    },
    # recordings
    "one sample": (bag(ONE), "realitygap: "),
    "the same message again and again": (bag(ONE, ONE, ONE), "realitygap: "),
    "values of another length": (bag((1.0, NAMES, [0.0], []), ONE), "names 2 joints and holds 1 values of position"),
    "a clock that jumps": (table(JUMPED), "the clock jumps from 0.290 to 3600.300 s"),
    "a clock that jumps in a scenario": (table(JUMPED, command="check"), "expected a clock without jumps"),
    "a table of sixty million rows": (table(many_rows(), "run.parquet"), "holds 60000000 rows of 4 columns"),
    "a bomb": (table(bomb(), "run.csv.zst"), "unpacks to more than 256 MiB"),
    "a chunk that is a bomb": (mcap_file(chunk_bomb), "unpacks to more than 256 MiB"),
    "a definition that never ends": (
        mcap_file(lambda: definition(200_000 * b"# a comment\n")),
        "its message definitions have more than 100,000 lines",
    ),
    "a definition of a hundred thousand fields": (
        mcap_file(lambda: definition(b"".join(b"float64 x%d\n" % k for k in range(99_000)))),
        "its message definitions have more than 100,000 lines, 5,000 in one",
    ),
    "a definition of parentheses": (
        mcap_file(
            lambda: definition(b"module a { const long C = %b1%b; };" % (20_000 * b"(", 20_000 * b")"), b"ros2idl")
        ),
        "the bag cannot be read (nested too deeply)",
    ),
    "stamps a nanosecond apart": (
        bag(*((1.0 + 1e-9 * k, NAMES, [0.1 * k, 0.0], []) for k in range(30))),
        "run.mcap: /joint_states: the samples are 1e-09 s apart, as those of no bus",
    ),
    "messages without names": (
        lambda: (
            files(run__mcap=mcap([(1.0 + 0.01 * k, [], [0.1, 0.0], []) for k in range(30)]), scenario__yaml=STATES),
            CHECK,
        ),
        "has no joint shoulder, elbow; it has none",
    ),
    "a table of words without time": (table(b"a,b\nx,y\ny,z\nz,x\n"), "has no column of time"),
    "a table cut off": (table(template.parquet()[:500], "run.parquet"), "is not a table"),
    # devices
    "a device as a recording": (
        scenario(recordings={"runs": [{"path": "/dev/zero"}]}),
        "is a pipe, a socket or a device",
    ),
    "a device as a robot": (scenario(robot={"urdf": "/dev/zero"}), "is a pipe, a socket or a device"),
    "a device as a scenario": (lambda: (files(), ["check", "/dev/zero"]), "is a pipe, a socket or a device"),
    "a device as a matrix": (lambda: (files(), ["matrix", "/dev/zero", *NEW]), "is a pipe, a socket or a device"),
    # files that people write, but not so
    "a list of two million values": (
        lambda: (files(scenario__yaml=b"name: a\nsuspects:\n" + 2_000_000 * b"- x\n"), CHECK),
        "scenario.yaml: holds more than 100000 values",
    ),
    # names
    "a line end in a name": (scenario(effects=[{"effect": "a\nb\x1b[31m"}]), "unknown effect a\\nb\\x1b[31m"),
    "a key that is long": (scenario(**{"k" * 500: 1}), "unknown key"),
    "a name with mathematics in it": (
        lambda: (files(scenario__yaml=dumped(SCENARIO | {"name": r"a$\frac{$b"})), SIMULATE),
        "'ok'",
    ),
}
