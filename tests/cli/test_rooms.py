"""The house as its imports draw it: rooms on floors, arrows that go down only, files that stay small."""

import ast
from functools import cache
from pathlib import Path

import pytest
from realitygap.matrix.digest import ROOMS

TOP = Path(__file__).parents[2]
PACKAGES = {"realitygap_engines": TOP / "engines" / "realitygap_engines", "realitygap": TOP / "harness" / "realitygap"}
FILES = {
    ".".join([name, *path.relative_to(folder).with_suffix("").parts]).removesuffix(".__init__"): path
    for name, folder in PACKAGES.items()
    for path in sorted(folder.rglob("*.py"))
}
FACE = "realitygap"
"""`import realitygap` and `python -m realitygap` stand before the house and may know every room."""
FLOORS = (  # as DESIGN draws them: a room knows only what lies below
    ("realitygap_engines",),
    ("files", "trace", "page"),
    ("scenario",),
    ("recording", "robot"),
    ("simulate", "audit", "check"),
    ("compare", "bench", "missing", "init"),
    ("matrix", "report", "diagnose"),
    ("cli",),
)
PAIRS = {  # of one floor, the rooms that know another: page and trace write their files whole
    "trace": {"files"},
    "page": {"files"},
}
MOST_ROOMS, MOST_FLOORS, MOST_LINES = 20, 7, 350


@cache
def imported(module: str) -> frozenset[str]:
    """The modules of the house that a module imports, anywhere in it but for the eyes of a type checker."""
    package = module if FILES[module].name == "__init__.py" else module.rpartition(".")[0]
    found = set()
    tree = ast.parse(FILES[module].read_text(encoding="utf-8"))
    unseen = {n for i in ast.walk(tree) if isinstance(i, ast.If) and ast.unparse(i.test) == "TYPE_CHECKING"
              for n in ast.walk(i)}  # fmt: skip
    for node in set(ast.walk(tree)) - unseen:
        if isinstance(node, ast.Import):
            found |= {a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package.split(".")[: len(package.split(".")) - node.level + 1]) if node.level else ""
            origin = ".".join(p for p in (base, node.module) if p)
            found |= {n if (n := f"{origin}.{a.name}") in FILES else origin for a in node.names}
    return frozenset(m for m in found if m in FILES) - {module}


def room(module: str) -> str:
    """The room that a module stands in."""
    top, *inner = module.split(".")
    return top if top == "realitygap_engines" or not inner or inner[0] == "__main__" else inner[0]


def arrows() -> dict[str, set[str]]:
    """Which rooms each room knows."""
    out: dict[str, set[str]] = {room(m): set() for m in FILES}
    for module in FILES:
        out[room(module)] |= {room(other) for other in imported(module)} - {room(module), FACE}
    return out


def circles(graph: dict[str, set[str]]) -> list[str]:
    """The nodes that know themselves by way of others."""
    out = []
    for node in graph:
        reached: set[str] = set()
        todo = list(graph[node])
        while todo:
            other = todo.pop()
            if other not in reached:
                reached.add(other)
                todo += graph[other]
        out += [node] if node in reached else []
    return out


def floor_of(graph: dict[str, set[str]], node: str) -> int:
    """The floor that a room needs at least: one above the highest that it knows."""
    return 1 + max((floor_of(graph, other) for other in graph[node]), default=0)


def test_there_are_few_rooms_on_few_floors() -> None:
    graph = {r: others for r, others in arrows().items() if r != FACE}
    assert not circles(graph)
    assert len(graph) <= MOST_ROOMS
    house = {r: others - {"realitygap_engines"} for r, others in graph.items() if r != "realitygap_engines"}
    assert max(floor_of(house, r) for r in house) <= MOST_FLOORS


@pytest.mark.parametrize("name", sorted(set(arrows()) - {FACE}))
def test_a_room_knows_only_what_lies_below(name: str) -> None:
    above = next(i for i, rooms in enumerate(FLOORS) if name in rooms)
    below = {r for rooms in FLOORS[:above] for r in rooms} | PAIRS.get(name, set())
    assert arrows()[name] <= below


def test_no_module_knows_itself_by_way_of_others() -> None:
    assert not circles({m: set(imported(m)) for m in FILES})


@pytest.mark.parametrize(
    "path", [*FILES.values(), *sorted((TOP / "tests").rglob("*.py"))], ids=lambda p: p.relative_to(TOP).as_posix()
)
def test_files_are_small(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= MOST_LINES


def test_a_cell_depends_on_the_rooms_that_compute_it_and_on_no_other() -> None:
    """What the code of a cell imports, directly or not, is what its key is made of."""
    reached, todo = set(), ["realitygap.matrix.task"]
    while todo:
        module = todo.pop()
        if module not in reached:
            reached.add(module)
            todo += imported(module)
    assert {room(m) for m in reached} == {"matrix", "realitygap_engines", *ROOMS}
    assert {m for m in reached if room(m) == "matrix"} == {"realitygap.matrix.task"}
