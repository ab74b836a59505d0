"""A process with everything imported that runs commands in forked children: a case costs milliseconds, not seconds.

It reads a JSON list per line, the folder to work in and the command's arguments, and answers with one JSON object per
line: exit status (negative: the signal), what was said, the largest memory [MiB] and seconds.
"""

import contextlib
import json
import os
import resource
import signal
import sys
import tempfile
import time
import warnings
from pathlib import Path

LIMIT = 60
"""s after which a case counts as hung."""
ADDRESSES = 10 << 30
"""Bytes of address space: more than any case may use, less than the machine has."""


def prepare() -> None:
    """Import what commands import, so that children need not."""
    import realitygap.audit.audit
    import realitygap.bench.ground
    import realitygap.bench.links
    import realitygap.bench.page
    import realitygap.bench.servo
    import realitygap.bench.supply
    import realitygap.check.check
    import realitygap.cli.main
    import realitygap.cli.results
    import realitygap.init.draft
    import realitygap.recording.readers.lerobot
    import realitygap.recording.readers.rosbag
    import realitygap.recording.readers.table
    import realitygap.report  # noqa: F401
    import realitygap_engines as engines

    for name in engines.available():
        engines.load(name)


def simulate(arguments: list[str]) -> None:
    """A robot in one engine, in this process: what `run` does in a worker."""
    from realitygap.compare.library import compare
    from realitygap_engines import RealityGapError
    from realitygap_engines.errors import in_a_line

    engine, scenario = arguments
    try:
        done = compare(scenario, [engine], floors=False)
    except RealityGapError as error:
        sys.stderr.write(f"realitygap: {in_a_line(error, 1000)}\n")
        raise SystemExit(2) from None
    sys.stdout.write(repr({c.outcome: c.note for c in done.comparisons}))


def run(folder: str, arguments: list[str]) -> None:
    """The child: ends with the command."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.setsid()
    os.chdir(folder)
    signal.alarm(10 * LIMIT)  # by the clock of the wall, which stands for little on a busy machine
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
    status = 0
    try:
        if arguments[0] == "simulate":
            simulate(arguments[1:])
        else:
            from realitygap.cli.main import main

            main(arguments)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException:
        import traceback

        traceback.print_exc()
        status = 99
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def case(folder: str, arguments: list[str]) -> dict[str, object]:
    """Run a command in a child and tell what became of it."""
    began = time.monotonic()
    with tempfile.TemporaryFile() as said:
        child = os.fork()
        if child == 0:
            os.dup2(said.fileno(), 1)
            os.dup2(said.fileno(), 2)
            run(folder, arguments)
        _, status, used = os.wait4(child, 0)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        said.seek(0)
        text = said.read(100_000).decode("utf-8", "replace")
    return {
        "status": os.waitstatus_to_exitcode(status),
        "said": text,
        "memory": used.ru_maxrss // 1024,
        "seconds": round(time.monotonic() - began, 2),
    }


if __name__ == "__main__":
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    sys.path[:0] = [str(Path(__file__).parents[2] / p) for p in ("engines", "harness")]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        prepare()
    for line in sys.stdin:
        answers.write(json.dumps(case(*json.loads(line))) + "\n")
        answers.flush()
