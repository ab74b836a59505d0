"""Cases by kind: the files of a folder, and the command that is run in it."""

import re
from collections.abc import Callable
from pathlib import Path

import realitygap_engines as engines
from fuzz import template
from fuzz.strategies import altered, damaged, numbers, words
from hypothesis import strategies as st

Case = tuple[dict[str, bytes], list[str]]
NEW = ["--out", "new"]
RUN = ["run", "scenario.yaml", "--engine", "mujoco", *NEW]
CHECK = ["check", "scenario.yaml"]
SIMULATE = ["simulate", "mujoco", "scenario.yaml"]


@st.composite
def scenario(draw: st.DrawFn) -> Case:
    """A scenario file with other content."""
    content = draw(altered(template.SCENARIO).map(template.dumped) | damaged(template.dumped(template.SCENARIO)))
    return template.files(scenario__yaml=content), draw(
        st.sampled_from([CHECK, CHECK, ["simulate", "mujoco", "scenario.yaml"]])
    )


@st.composite
def animation(draw: st.DrawFn) -> Case:
    """An animation with other content."""
    moved = template.SCENARIO | {"motion": {"keyframes": "move.json"}, "recordings": None}
    content = draw(altered(template.ANIMATION).map(template.dumped) | damaged(template.dumped(template.ANIMATION)))
    return template.files(scenario__yaml=template.dumped(moved), move__json=content), [
        "simulate",
        "mujoco",
        "scenario.yaml",
    ]


@st.composite
def matrix(draw: st.DrawFn) -> Case:
    """A matrix file with other content."""
    content = draw(altered(template.MATRIX).map(template.dumped) | damaged(template.dumped(template.MATRIX)))
    return template.files(matrix__yaml=content), ["matrix", "matrix.yaml", "--dry-run", *NEW]


@st.composite
def bench(draw: st.DrawFn) -> Case:
    """A bench file with other content, or a table of it."""
    kind = draw(st.sampled_from(sorted(template.BENCHES)))
    content = template.BENCHES[kind]
    tables = {
        "voltages.csv": b"motor,current,voltage\nm0,1,14.5\nm0,2,14.2\nm0,3,13.9\n",
        "masses.csv": b"part,mass\nfore,1.25\nfore,1.26\n",
        "torque_speed.csv": b"type,supply,load,torque,speed\nMX,14.8,0.1,0.5,7\nMX,14.8,0.2,1,6\nMX,14.8,0.3,2,5\n",
    }
    if draw(st.booleans()):
        text = draw(altered(content).map(template.dumped) | damaged(template.dumped(content)))
    else:
        text, name = template.dumped(content), draw(st.sampled_from(sorted(tables)))
        tables[name] = draw(damaged(tables[name]))
    return template.files(bench__yaml=text) | tables, ["bench", kind, "bench.yaml", *NEW]


VALUE = re.compile(r'(?<==")[^"]*(?=")')


@st.composite
def urdf(draw: st.DrawFn) -> Case:
    """A URDF with other numbers and names."""
    text = template.URDF
    for _ in range(draw(st.integers(1, 3))):
        found = draw(st.sampled_from(list(VALUE.finditer(text))))
        value = draw(
            numbers.map(repr) | st.lists(numbers, min_size=3, max_size=3).map(lambda v: " ".join(map(repr, v))) | words
        )
        text = text[: found.start()] + value.replace('"', "").replace("<", "") + text[found.end() :]
    content = draw(st.just(text.encode("utf-8", "replace")) | damaged(template.URDF.encode()))
    engine = draw(st.sampled_from(engines.available()))
    commands = [["simulate", engine, "scenario.yaml"], ["init", "arm.urdf", "run.csv", *NEW], CHECK]
    return template.files(arm__urdf=content), draw(st.sampled_from(commands))


def _reads(path: str) -> st.SearchStrategy[list[str]]:
    return st.sampled_from([["init", "arm.urdf", path, *NEW], CHECK])


@st.composite
def bag(draw: st.DrawFn) -> Case:
    """A bag that was cut off, flipped, or recorded by a program with other ideas."""
    if draw(st.booleans()):
        content = draw(damaged(template.bag()))
    else:
        row = st.lists(numbers.filter(lambda v: abs(v) < 1e308 or v != v), max_size=3)
        names = st.sampled_from([list(template.JOINTS), list(template.JOINTS)[::-1], ["elbow"], [], ["a\nb", "elbow"]])
        stamps = st.sampled_from([0.0, 1e-9, 0.01, 1.0, 3600.0, 2.0**31]) | st.floats(0, 10)
        messages = draw(st.lists(st.tuples(stamps, names, row, row), min_size=0, max_size=6))
        usual: list[tuple[float, list[str], list[float], list[float]]] = [
            (0.5 + 0.01 * k, list(template.JOINTS), [0.1 * k, 0.0], [])
            for k in range(draw(st.sampled_from([0, 1, 2, 30])))
        ]
        content = template.mcap(messages + usual)
    state = template.SCENARIO | {
        "recordings": {"state": "/joint_states", "effort": "none", "runs": [{"path": "run.mcap"}]},
        "motion": {"recorded": "/joint_states"},
    }
    return template.files(run__mcap=content, scenario__yaml=template.dumped(state)), draw(_reads("run.mcap"))


@st.composite
def table(draw: st.DrawFn) -> Case:
    """A table that was damaged, or filled by a program with other ideas."""
    name = draw(st.sampled_from(["run.csv", "run.parquet"]))
    content = draw(damaged(template.csv() if name == "run.csv" else template.parquet()))
    used = template.SCENARIO | {"recordings": {"effort": "none", "runs": [{"path": name}]}}
    return template.files(scenario__yaml=template.dumped(used)) | {name: content}, draw(_reads(name))


@st.composite
def results_of(draw: st.DrawFn, folder: Path) -> Case:
    """A result folder with files that were damaged."""
    files = {f"results/{p.relative_to(folder)}": p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    for name in draw(st.lists(st.sampled_from(sorted(files)), min_size=1, max_size=2)):
        files[name] = draw(damaged(files[name]) | st.just(b""))
    return files, ["report", "results"]


KINDS: dict[str, Callable[[], st.SearchStrategy[Case]]] = {
    f.__name__: f for f in (scenario, animation, matrix, bench, urdf, bag, table)
}
"""Each makes cases of one kind; `results_of` needs a folder that was made."""
