"""`realitygap bench links`: masses, centres of mass and inertias of a URDF, against scales and sense (thesis, 4.1)."""

from pathlib import Path

import numpy as np

from realitygap.bench import link_figures
from realitygap.bench.link_file import LinkBench, load_link_bench
from realitygap.bench.link_revision import Measured, measurements, read_tables, revised, revised_text
from realitygap.bench.plausible import Doubt, doubts
from realitygap.bench.summary import Summary
from realitygap.bench.urdf_links import UrdfLink, read_urdf_links
from realitygap.scenario.file import resolve_path

MIRROR = np.diag([1.0, -1.0, 1.0])


def run(bench: Path, out: Path) -> Summary:
    """Check a URDF's links and write the corrected URDF and the figure into a folder.

    Raises:
        InputError: one sentence on what cannot be used.
    """
    spec = load_link_bench(bench)
    packages = {name: resolve_path(bench, text, f"packages.{name}") for name, text in spec.packages.items()}
    urdf = read_urdf_links(resolve_path(bench, spec.urdf, "urdf"), packages)
    found = measurements(bench, spec, urdf)
    summary = Summary()
    _masses(urdf.links, found, summary)
    _centers(bench, spec, urdf.links, found, summary)
    before = _doubts("Implausible links", urdf.links, summary)
    _asymmetry(spec, urdf.links, summary)
    if found:
        words = {name: revised(urdf.links[name], what) for name, what in found.items()}
        after = urdf.links | {name: link for name, (link, _) in words.items()}
        summary.section("Corrected URDF")
        for name, (_, how) in words.items():
            summary.lines.append(f"{name}: inertia {how}")
        corrected = out / f"{urdf.path.stem}_corrected.urdf"
        summary.write(corrected, revised_text(urdf, {name: link for name, (link, _) in words.items()}))
        remaining = _doubts("What remains implausible after the correction", after, summary)
        _asymmetry(spec, after, summary)
        pictures = [("as stated", urdf.links, before), ("corrected", after, remaining)]
    else:
        pictures = [("as stated", urdf.links, before)]
    summary.files.append(link_figures.draw(urdf, pictures, out / "links.png"))
    summary.write(out / "summary.txt", "\n".join(summary.lines) + "\n")
    return summary


def _masses(links: dict[str, UrdfLink], found: dict[str, Measured], summary: Summary) -> None:
    rows = []
    stated = weighed = 0.0
    for name, what in found.items():
        if what.mass is None:
            continue
        error = what.mass / links[name].mass - 1 if links[name].mass > 0 else np.inf
        stated, weighed = stated + links[name].mass, weighed + what.mass
        verdict = "WRONG BY MORE THAN 100 %" if abs(error) > 1 else "accurate" if abs(error) < 0.03 else ""
        rows.append([name, f"{links[name].mass:.4f}", f"{what.mass:.4f}", f"{error:+.1%}", verdict])
    total = sum(link.mass for link in links.values())
    if rows:
        summary.section("Masses [kg]; the error is of the measured against the stated mass")
        rows.append(["weighed links", f"{stated:.4f}", f"{weighed:.4f}", f"{weighed / stated - 1:+.1%}", ""])
        summary.table(["link", "stated", "measured", "error", ""], rows)
        rest = {n: x.mass for n, x in links.items() if n not in found or found[n].mass is None}
        if rest:
            summary.lines.append(f"not weighed: {', '.join(f'{n} {m:g}' for n, m in rest.items())}")
        summary.lines.append(
            f"whole robot: {total:.3f} kg stated, {total - stated + weighed:.3f} kg with the measured links"
        )
    else:
        summary.section("Masses [kg]")
        summary.lines.append(f"whole robot: {total:.3f} kg stated; nothing was weighed")


def _centers(
    path: Path, spec: LinkBench, links: dict[str, UrdfLink], found: dict[str, Measured], summary: Summary
) -> None:
    _, centers = read_tables(path, spec)
    if centers is None or spec.centers is None:
        return
    summary.section("Centres of mass [mm]")
    if {"cad_x", "cad_y", "cad_z"} <= set(centers.columns):
        mean = [float((centers[a] - centers[f"cad_{a}"]).abs().mean()) for a in "xyz"]
        text = ", ".join(f"{a} {m:.3f} m" for a, m in zip("xyz", mean, strict=True))
        summary.lines.append(f"average difference of measured and CAD values: {text}")
    rows = []
    for name, what in found.items():
        if what.com is None:
            continue
        off = what.com - links[name].com
        mark = "more than 20 mm" if np.linalg.norm(off) > 0.02 else ""
        cells = [" ".join(f"{1e3 * v:+6.1f}" for v in vector) for vector in (links[name].com, what.com, off)]
        rows.append([name, *cells, f"{1e3 * np.linalg.norm(off):.1f}", mark])
    summary.table(["link", "stated x y z", f"{spec.centers.use} x y z", "difference", "distance", ""], rows)


def _doubts(title: str, links: dict[str, UrdfLink], summary: Summary) -> list[Doubt]:
    summary.section(title)
    found = [d for link in links.values() for d in doubts(link)]
    for d in sorted(found, key=lambda d: not d.impossible):
        summary.lines.append(f"{'IMPOSSIBLE' if d.impossible else 'implausible'}: {d.link}: {d.what}")
    if not found:
        summary.lines.append("nothing found")
    return found


def _asymmetry(spec: LinkBench, links: dict[str, UrdfLink], summary: Summary) -> None:
    """Pairs of links that are not each other's mirror image."""
    lines = []
    for first, second in spec.mirror:
        for name, link in links.items():
            other = links.get(second + name.removeprefix(first)) if name.startswith(first) else None
            if other is None:
                continue
            heavier = abs(link.mass - other.mass) / max(link.mass, other.mass)
            apart = float(np.linalg.norm(MIRROR @ link.com - other.com))
            size = float(np.linalg.norm(other.inertia))
            tensor = float(np.linalg.norm(MIRROR @ link.inertia @ MIRROR - other.inertia)) / size if size else 0.0
            parts = [
                *([f"masses differ by {heavier:.1%}"] if heavier > 1e-3 else []),
                *([f"centres of mass by {apart * 1e3:.1f} mm"] if apart > 1e-3 else []),
                *([f"inertias by {tensor:.0%}"] if tensor > 0.02 else []),
            ]
            if parts:
                lines.append(f"{name} and {other.name} are no mirror images: {', '.join(parts)}")
    if lines:
        summary.lines += ["", *lines]
