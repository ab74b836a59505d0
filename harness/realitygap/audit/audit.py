"""The audit: is this the same machine in every engine?"""

from pathlib import Path

import realitygap_engines as engines
from realitygap_engines import Engine

from realitygap.audit import between, ground, joints, motion
from realitygap.audit.certificate import Certificate, Proof
from realitygap.audit.check import Check
from realitygap.audit.dynamics import checks_of
from realitygap.audit.machines import tree
from realitygap.audit.oracle import pinocchio
from realitygap.audit.robot import AuditedRobot, load_robot
from realitygap.files.progress import Progress
from realitygap.scenario.engine_names import engine_names


def audit(path: Path | None, names: list[str], out: Path | None = None, *, quiet: bool = False) -> Certificate:
    """Audit engines on the bundled machines and, where a path is given, on that robot.

    Args:
        path: a URDF or a scenario; None for the bundled test machines only.
        names: engines; empty for all that are installed.
        out: a folder for audit.json and audit.csv.
        quiet: show no progress.

    Raises:
        InputError: for an engine that is unknown or not installed, a missing Pinocchio, or a path that cannot be used.
    """
    pinocchio()
    robot = load_robot(path) if path is not None else None
    audited = [engines.load(name) for name in engine_names(names)]
    certificate = certify(audited, robot, Progress(quiet=quiet))
    if out is not None:
        certificate.write(out)
    return certificate


def certify(audited: list[Engine], robot: AuditedRobot | None = None, progress: Progress | None = None) -> Certificate:
    """The certificate of these engines."""
    rows: list[Proof] = []
    found = groups(robot)
    with (progress or Progress(quiet=True)).task("audit", len(found) * len(audited) + 1) as advance:
        for name, checks in found.items():
            for engine in audited:
                advance(f"{name} in {engine.name}")
                rows += [check.row(engine) for check in checks]
        advance("the same motion in all engines")
        rows += between.chain_rows(audited)
        rows += between.contact_rows(audited)
        if robot is not None:
            if robot.model.joints:
                rows += between.free_rows(audited, robot.model, robot.timestep)
            rows += robot.rows()
    versions = {engine.name: engine.version for engine in audited}
    return Certificate(tuple(rows), {**versions, "pinocchio": pinocchio().__version__}, robot.facts if robot else {})


def groups(robot: AuditedRobot | None = None) -> dict[str, tuple[Check, ...]]:
    """All checks of one engine, by what they are about."""
    found = {
        "machine": (*checks_of(tree(), "tree"), *checks_of(tree(False), "arm")),
        "motion": motion.CHECKS,
        "joints": joints.CHECKS,
        "ground": ground.CHECKS,
    }
    if robot is not None:
        found["robot"] = checks_of(robot.model, "robot", robot.timestep, way_tolerance=1e-2)
    return found
