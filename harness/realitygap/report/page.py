"""`report.html`: a page that opens offline, a pure function of the result folder. Many curves stay beside it."""

import base64
import json
import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from realitygap.compare.traces import read_traces
from realitygap.files.found import counted
from realitygap.files.whole import write_whole
from realitygap.page.shell import render
from realitygap.page.style import engine_label, number
from realitygap.report.curves import write_curves
from realitygap.report.each import Each, one_by_one
from realitygap.report.folder import Results, read_folder
from realitygap.report.missing import missing_pictures
from realitygap.report.payload import payload
from realitygap.report.sentences import sentences
from realitygap.report.spread import spread
from realitygap.report.thesis import HEAD, PUBLISHED, grounds, improvements, is_wolfgang

SCRIPTS = ("format", "data", "state", "switches", "heatmap", "plot", "zoom", "detail", "tables", "tradeoffs", "main")
SHOWN = 8
"""Sentences shown at once; the others are a click away."""
MAILABLE = 4_000_000
"""Curves up to this many bytes travel inside the page; larger ones are loaded from the files beside it."""
OF_GROUND = ("rigid_ground", "soft_ground")
OF_JOINTS = ("armature", "forward_dynamics", "joint_damping", "joint_friction", "joint_limits", "mimic_joints")
OF_LONE_BODY = "lone_body"
"""Capabilities of engines by what they are about."""
REPEATED = re.compile(r" ×\d+$")
"""How the name of a mean over repetitions ends."""
TAGS = {
    "virtual": "caution",
    "mistake": "check this",
    "failed": "did not finish",
    "closest": "closest",
    "gap": "gap",
    "change": "change",
    "enough": "enough",
    "speed": "speed",
    "joint": "worst joint",
}


def write_page(folder: Path, out: Path | None = None, each: Each = one_by_one) -> Path:
    """Write `report.html` and its `curves/`, from the table and traces of a result folder. Returns the page.

    Args:
        folder: the result folder.
        out: where to write (default: there).
        each: does work for every item, in other processes where there are some.

    Raises:
        InputError: where the folder holds no result table, or a file of it is damaged.
    """
    results = read_folder(folder)
    out = out or folder
    written = each(_curves_of, [(path, out) for path in results.traces.values()])
    drawn = sorted({file for found in written for file in found})
    web = files("realitygap.report") / "web"
    said = sentences(results)
    text = render(
        "realitygap.report",
        "page.html.j2",
        title=results.manifest.get("scenario") or " and ".join(str(s) for s in results.axes["scenario"]) or folder.name,
        summary=_summary(results),
        virtual=results.virtual,
        sentences=said,
        shown=SHOWN if len(said) > SHOWN + 1 else len(said),
        tags=TAGS,
        curves_there=bool(results.traces),
        rounded=_rounded(results),
        missing=_missing(results, out),
        published=_published() if is_wolfgang(results) else (),
        spread=_spread_rows(results, each),
        settings=_settings(results),
        limitations=_limitations(results),
        provenance=_provenance(results),
        js=_raw("\n".join((web / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS)),
        data=_raw(json.dumps(payload(results), separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")),
        curves=_raw(_inlined(drawn)),
    )
    path = out / "report.html"
    write_whole(path, text)
    return path


def _curves_of(cell: tuple[Path, Path]) -> list[Path]:
    """Write the curves of the cell whose traces lie in a file, below a folder."""
    path, out = cell
    return write_curves(out, read_traces(path))


def _missing(results: Results, out: Path) -> list[tuple[str, str]]:
    """Of every joint: what its missing effort depends on, and the picture as a link that holds it; "" without one."""
    told = []
    for picture in missing_pictures(results, out):
        text = "" if picture.path is None else base64.b64encode(picture.path.read_bytes()).decode()
        told.append((picture.sentence, f"data:image/svg+xml;base64,{text}" if text else ""))
    return told


def _published() -> list[tuple[str, tuple[str, ...], Any]]:
    """The tables of the thesis: what they show, what the columns before the gaps are, and the rows."""
    return [
        ("The three revisions, on grass (tables 5.1, 5.2, 5.4, 5.5)", ("motion", "joints", "URDF"), PUBLISHED),
        ("Old − new; positive is better (table 5.6)", ("motion", "joints"), improvements()),
        ("A quick turn of the head: HeadPan (table 5.3)", ("URDF",), HEAD),
        ("Cheering, new URDF, recorded on flat ground and on grass (table 6.1)", ("joints", "ground"), grounds()),
    ]


def _raw(text: str) -> Any:
    from markupsafe import Markup

    return Markup(text)


def _summary(results: Results) -> str:
    counts = {
        "cell": len(results.cells),
        "engine": len(results.engines),
        "recording": results.cells["recording"].where(results.cells["recording"] != "").nunique(),
        "joint": results.gaps.loc[results.gaps["group"] != "base", "joint"].nunique(),
    }
    return " · ".join(counted(n, name) for name, n in counts.items() if n)


def _inlined(paths: Sequence[Path]) -> str:
    """The curve files themselves, where all of them together are small."""
    if sum(p.stat().st_size for p in paths) > MAILABLE:
        return ""
    return "".join(p.read_text(encoding="utf-8") for p in paths)


def _spread_rows(results: Results, each: Each) -> list[tuple[str, ...]]:
    return [
        (f"{engine_label(s.first)} and {engine_label(s.second)}", number(s.degrees), number(s.radians), str(s.cells))
        for s in spread(results, each)
    ]


def _settings(results: Results) -> dict[str, Any] | None:
    settings: dict[str, dict[str, Any]] = results.manifest.get("settings") or {}
    engines = [e for e in results.engines if e in settings]
    if not engines:
        return None
    keys = sorted({k for e in engines for k in settings[e]})
    told = [k for k in keys if any(settings[e].get(k) is not None for e in engines)]  # none: of what was not there
    rows = [(k, [_setting(settings[e].get(k)) for e in engines]) for k in told]
    versions = results.manifest.get("versions") or {}
    return {"engines": [f"{engine_label(e)} {versions.get(e) or ''}".strip() for e in engines], "rows": rows}


def _setting(value: Any) -> str:
    if value is None:
        return "–"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _limitations(results: Results) -> list[tuple[str, list[str]]]:
    """What each engine emulates or cannot express, and what was simplified in model and recordings."""
    out = []
    capabilities: dict[str, dict[str, Any]] = results.manifest.get("capabilities") or {}
    for engine in results.engines:
        lines = []
        for name, entry in sorted(capabilities.get(engine, {}).items()):
            if entry["level"] != "native" and _concerns(results, name):
                level = {"no": "not possible", "emulated": "emulated"}.get(entry["level"], entry["level"])
                lines.append(f"{name.replace('_', ' ')}: {level}. {entry['how']}")
        if lines:
            out.append((engine_label(engine), lines))
    for name, lines in (results.manifest.get("notes") or {}).items():
        if lines:
            out.append((name.capitalize(), [str(line) for line in lines]))
    return out


def _concerns(results: Results, capability: str) -> bool:
    """Whether a capability of an engine matters to what was simulated; where the table does not tell, it may."""
    gaps = results.gaps
    if capability in OF_GROUND:
        return any(str(ground) != "none" for ground in results.axes["ground"])
    if capability in OF_JOINTS or capability == OF_LONE_BODY:
        return gaps.empty or bool((gaps["group"] != "base").any()) == (capability in OF_JOINTS)
    return True


def _rounded(results: Results) -> bool:
    """Whether no motion was repeated, so that the noise floor is the rounding of readings; the names of means tell."""
    return not results.gaps.empty and not any(REPEATED.search(str(name)) for name in results.axes["recording"])


def _provenance(results: Results) -> list[tuple[str, str]]:
    manifest = results.manifest
    out = []
    if command := manifest.get("command_line"):
        out.append(("command line", command if isinstance(command, str) else " ".join(["realitygap", *command])))
    out += [(key, str(manifest[key])) for key in ("python", "platform") if manifest.get(key)]
    out += [(name, str(v)) for name, v in (manifest.get("versions") or {}).items() if v]
    out += [(name, str(digest)) for name, digest in (manifest.get("inputs") or {}).items()]
    return out
