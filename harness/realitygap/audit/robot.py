"""A team's own robot, ready to be audited, and what became of it on its way from its file."""

from dataclasses import dataclass, replace
from pathlib import Path

from realitygap_engines.errors import ModelError
from realitygap_engines.model.read import format_of, read_model
from realitygap_engines.model.robot import Model
from realitygap_engines.model.xacro_file import is_xacro

from realitygap.audit.certificate import Proof, Verdict
from realitygap.audit.check import largest
from realitygap.audit.described import described_inertia
from realitygap.audit.machines import FAR, random_state
from realitygap.audit.oracle import Oracle
from realitygap.files.errors import InputError
from realitygap.robot.effects.place import place
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario

TOLERANCE = 1e-9


@dataclass(frozen=True)
class AuditedRobot:
    """A robot to audit.

    Attributes:
        urdf: its file.
        described: the model as the file has it.
        model: the machine that is simulated, with the rotor inertia of its servos and with its effects. Its joint
            limits are out of reach and nothing mimics: random states are to show the dynamics.
        timestep: at which it is simulated [s].
    """

    urdf: Path
    described: Model
    model: Model
    timestep: float = 1e-3

    @property
    def facts(self) -> dict[str, object]:
        """What the model is made of, for people."""
        links = self.described.links
        lumped = [f"{x.name} carries {', '.join(x.merged[1:])}" for x in links if len(x.merged) > 1]
        mimics = [j.name for j in self.described.joints if j.mimic is not None]
        contact = [f"{x.name} ({len(x.spheres)})" for x in links if x.spheres]
        return {
            "robot": f"{self.described.name}, {len(self.described.joints)} joints, {self.described.mass:.4f} kg",
            "base": "floating" if self.described.floating else "fixed",
            "links that touch the ground (contact spheres)": contact or ["none"],
            "links lumped by fixed joints": lumped or ["none"],
            "mimic joints (audited without their coupling)": mimics or ["none"],
            "notes": list(self.described.notes) or ["none"],
        }

    def rows(self) -> list[Proof]:
        """Our reading of the file against somebody else's: mass and joint-space inertia."""
        if is_xacro(self.urdf, self.urdf.read_bytes()) or format_of(self.urdf) == "sdf":
            return []  # there is no other reader of these
        model = self.described
        position = random_state(model, 0).position
        total, inertia, judge = described_inertia(self.urdf, model, position)
        held = replace(model, floating=False)
        ours, _ = Oracle(held).inertia_and_bias(replace(random_state(held, 0), position=position))
        mass = model.mass if model.floating else sum(link.mass for link in model.links[1:])
        return [
            _row("file as read: mass", abs(mass - total) / max(1.0, total), judge),
            _row("file as read: mass matrix", largest(ours, inertia), judge),
        ]


def _row(name: str, error: float, judge: str) -> Proof:
    verdict: Verdict = "passed" if error <= TOLERANCE else "failed"
    return Proof(name, "model", float(error), TOLERANCE, "1", verdict, f"against {judge}")


def load_robot(path: Path) -> AuditedRobot:
    """The robot of a scenario, or of a URDF or MJCF alone: its base then floats, unless it has no mass.

    Raises:
        InputError: for a scenario or a robot's file that cannot be used (as ModelError).
    """
    if path.suffix in (".yaml", ".yml"):
        file = load_scenario(path)
        plant = build_plant(file)
        try:
            machine = place(plant, file.scenario.effects).machine()
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        urdf = file.resolve(file.scenario.robot.urdf, "robot.urdf")
        return AuditedRobot(urdf, plant.model, _unlimited(machine), file.scenario.timestep)
    try:
        model = read_model(path, floating=True)
    except ModelError:
        model = read_model(path, floating=False)
    return AuditedRobot(path, model, _unlimited(model))


def _unlimited(model: Model) -> Model:
    return replace(model, joints=tuple(replace(j, lower=-FAR, upper=FAR, mimic=None) for j in model.joints))
