"""Kills and signals at random moments of every command: does the next run put everything in order?

    python tests/bench_kills.py [--kills 100] [--signals 40] [--seed 1] [--only run matrix ...]

A kill is SIGKILL to the command, to its workers or to all of them at a random moment; a signal is SIGINT or SIGTERM to
the command. After every one no process of it may be left, and where the command was told to end, its folder is as
before. The same command is run again then: its tables are those of an undisturbed run, byte by byte, and nothing
unfinished lies in the folder or in that of the machine for temporary files. Signals are sent once the command listens
to them, which it does before it does anything. The scenario is the bundled demo, shortened; a rehearsal has so little
time that it tries no search that its clock could leave out, since tables are to be the same. Moments are shares of the
time that the last run in peace took, for machines are busy and less so. What met nothing alive, because the command had
ended or has no workers, is no trial: another one is drawn.
"""

import argparse
import contextlib
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import yaml

DEMO = Path(__file__).parents[1] / "scenarios" / "demo"
MARK = "REALITYGAP_TRIAL"
"""The variable in the environment by which the processes of a trial are known, whoever their parent is."""
GRACE = 5.0
"""s after which nothing of a killed command may be alive; its workers look every half second."""
YOUNG = 1.2
"""s after which what a killed process left counts as left."""
LATER = 1.2
"""Share of the last run in peace up to which the next is disturbed: one in a new folder takes longer."""
COMMANDS = {  # command: what is said after it, and the files that must not differ
    "run": ("scenario.yaml --engine mujoco --engine dart", ("gaps.csv",)),
    "matrix": ("matrix.yaml -j 2", ("gaps.csv",)),
    "report": ("", ("gaps.csv", "report.html")),
    "diagnose": ("scenario.yaml --engine mujoco -j 2", ("diagnosis.json",)),
    "rehearse": ("scenario.yaml --budget 1 -j 2", ("rehearsal.csv", "rehearsal.json")),
    "audit": ("arm.urdf --engine mujoco", ("audit.csv",)),
    "init": ("arm.urdf steps_1.mcap", ("scenario.yaml",)),
}
SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143}


@dataclass
class Place:
    """The folder of a command: the team's files, where it writes, and its folder for temporary files."""

    name: str
    folder: Path
    seconds: float = 0.0
    """What the last run in peace took."""

    @property
    def out(self) -> Path:
        """Where the command writes."""
        return self.folder / "out"

    def start(self, mark: str) -> subprocess.Popen[str]:
        """The command, begun; in a group of its own."""
        said, _ = COMMANDS[self.name]
        words = [sys.executable, "-m", "realitygap.cli.main", self.name, *said.split()]
        words += ["out"] if self.name == "report" else ["--out", "out"]
        environment = os.environ | {MARK: mark, "TMPDIR": str(self.folder / "tmp")}
        return subprocess.Popen(
            words, cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )

    def tables(self) -> dict[str, str]:
        """What must not differ."""
        files = (self.out / name for name in COMMANDS[self.name][1])
        return {f.name: hashlib.sha256(f.read_bytes()).hexdigest() for f in files if f.exists()}

    def content(self) -> dict[str, str]:
        """Every file in the folder that is no work in progress, by what it holds; cells that are done may be more."""
        found = (f for f in self.out.rglob("*") if f.is_file() and "cells" not in f.parts)
        return {str(f): hashlib.sha256(f.read_bytes()).hexdigest() for f in found}

    def left(self) -> list[str]:
        """What is unfinished, here and among temporary files."""
        places = [*self.folder.glob(".*"), *self.out.rglob(".*"), *(self.folder / "tmp").glob("*")]
        return [p.name for p in places]


def made(folder: Path) -> Path:
    """The demo with two short runs, and a matrix of it."""
    shutil.copytree(DEMO, folder)
    content = yaml.safe_load((folder / "scenario.yaml").read_text(encoding="utf-8"))
    runs = [("steps_1.mcap", "train"), ("triangle_1.mcap", "held_out")]
    content["recordings"]["runs"] = [{"path": p, "use": use, "window": [0.0, 1.5]} for p, use in runs]
    content["suspects"] = ["coulomb_friction", "viscous_friction", "command_delay"]
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    matrix = {
        "name": "kills",
        "scenarios": ["scenario.yaml"],
        "engines": ["mujoco"],
        "axes": {"step_rate": [1000, 2000]},
    }
    (folder / "matrix.yaml").write_text(yaml.safe_dump(matrix), encoding="utf-8")
    (folder / "tmp").mkdir()
    return folder


def alive(mark: str) -> list[int]:
    """The processes of a trial."""
    out = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (place / "environ").read_bytes().split(b"\0"):
                out.append(int(place.name))
        except OSError:
            continue
    return out


def waited(mark: str) -> list[int]:
    """The processes of a trial that are left after the time that they have to end."""
    end = time.monotonic() + GRACE
    while (found := alive(mark)) and time.monotonic() < end:
        time.sleep(0.1)
    return found


def listens(pid: int) -> bool:
    """Whether a command answers signals by itself: Python leaves SIGTERM alone."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    caught = next(int(line.split()[1], 16) for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def disturb(process: subprocess.Popen[str], mark: str, how: str) -> bool:
    """Kill the command, its workers or all; whether any of them was alive."""
    if process.poll() is not None:
        return False
    victims = {"parent": [process.pid], "workers": [p for p in alive(mark) if p != process.pid], "all": alive(mark)}
    for pid in victims[how]:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            continue
    return bool(victims[how])


def trial(
    place: Place, reference: dict[str, str], moment: float, how: str | signal.Signals, mark: str
) -> list[str] | None:
    """What was wrong after one disturbance and after the run that followed; None where nothing alive was met."""
    before = place.content()
    process = place.start(mark)
    while isinstance(how, signal.Signals) and process.poll() is None and not listens(process.pid):
        time.sleep(0.02)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(moment)
    wrong = []
    if isinstance(how, signal.Signals):
        early = process.poll() is not None
        process.send_signal(how)
        said = process.communicate()[1]
        if early:
            return None
        if process.returncode not in (SIGNALS[how], 0):
            wrong.append(f"ended with {process.returncode}: {said[-500:]}")
        elif process.returncode == SIGNALS[how] and place.name != "init" and place.content() != before:
            wrong.append("told to end, it left the folder in another state")
    else:
        met = disturb(process, mark, how)
        said = process.communicate()[1]
        if not met:
            return None
    if "Traceback" in said:
        wrong.append(f"a traceback: {said[-1500:]}")
    orphans = waited(mark)
    wrong += [f"{len(orphans)} processes were left"] * bool(orphans)
    for pid in orphans:
        os.kill(pid, signal.SIGKILL)
    if isinstance(how, signal.Signals) and place.left():
        wrong.append(f"left {place.left()} behind")
    time.sleep(YOUNG)
    if place.name == "init" and place.tables():  # what is done is not done again in the same place
        wrong += ["left another scenario"] * (place.tables() != reference)
        shutil.rmtree(place.out)
    return wrong + again(place, reference)


def again(place: Place, reference: dict[str, str]) -> list[str]:
    """What is wrong after the same command was run in peace."""
    began = time.monotonic()
    process = place.start("peace")
    said = process.communicate()[1]
    place.seconds = time.monotonic() - began
    wrong = [f"the next run ended with {process.returncode}: {said[-800:]}"] * (process.returncode not in (0, 1))
    if reference and place.tables() != reference:
        wrong.append("the next run has other tables")
    if orphans := waited("peace"):
        wrong.append(f"the next run left {len(orphans)} processes")
    if place.left():
        wrong.append(f"the next run left {place.left()}")
    return wrong


def say(line: str) -> None:
    """A line, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main() -> int:
    """A line per trial and per command; how many trials went wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--signals", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", default=[*COMMANDS])
    args = parser.parse_args()
    draw, bad, done = random.Random(args.seed), Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        for k, command in enumerate(args.only):
            place = Place(command, made(Path(name) / command))
            if command == "report":
                ran = Place("run", made(Path(name) / "ran"))
                assert not again(ran, {})
                shutil.copytree(ran.out, place.out)
            said = again(place, {})  # the first one compiles
            assert not said, said
            if command != "report":
                shutil.rmtree(place.out)
            said += again(place, {})
            reference = place.tables()
            assert not said, said
            assert reference, f"{command} wrote none of {COMMANDS[command][1]}"
            shares = [len(range(k, n, len(args.only))) for n in (args.kills, args.signals)]
            hows: dict[str, list[str | signal.Signals]] = {"kills": ["parent", "workers", "all"], "signals": [*SIGNALS]}
            for kind, number in [(kind, n) for kind, share in zip(hows, shares, strict=True) for n in range(share)]:
                wrong, tries = None, 0
                while wrong is None:
                    if command != "report" and draw.random() < 0.5:
                        shutil.rmtree(place.out, ignore_errors=True)  # the folder is a new one
                    if command == "init":
                        shutil.rmtree(place.out, ignore_errors=True)
                    how, moment = draw.choice(hows[kind]), draw.uniform(0.0, LATER * place.seconds)
                    mark, tries = f"{args.seed}-{command}-{kind}-{number}-{tries}", tries + 1
                    wrong = trial(place, reference, moment, how, mark)
                done[kind] += 1
                bad[kind] += len(wrong)
                told = f"{command} {kind} {number + 1}: {how} after {moment:.2f} of {place.seconds:.2f} s"
                say(f"{told}: {'; '.join(wrong) or 'in order'}")
    for kind, count in done.items():
        say(f"seed {args.seed}: {count} {kind}, {bad[kind]} things wrong")
    return sum(bad.values())


if __name__ == "__main__":
    sys.exit(bool(main()))
