"""The missing effort as a library: of every recording of a scenario, and what it depends on."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import pandas as pd

from realitygap.files.errors import InputError, did_you_mean
from realitygap.files.found import counted
from realitygap.missing.effort import MissingEffort, missing_of
from realitygap.missing.shape import Shape, shape_of
from realitygap.missing.words import sentence
from realitygap.scenario.added_effects import Effect, added_effects
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import Source, load_scenario
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.experiment import experiments


@dataclass(frozen=True)
class Missing:
    """What a scenario's model lacks, as efforts on its joints.

    Attributes:
        scenario: its name.
        runs: the missing effort of every recording.
    """

    scenario: str
    runs: tuple[MissingEffort, ...]
    _fitted: dict[str, Shape] = field(default_factory=dict, repr=False, compare=False)

    def __repr__(self) -> str:
        return f"<Missing {self.scenario}: {counted(len(self.runs), 'recording')} of {', '.join(self.runs[0].joints)}>"

    def shape(self, joint: str) -> Shape:
        """What the missing effort of a joint depends on, told from the recordings that are not held out.

        Raises:
            InputError: for a joint that the robot does not have.
        """
        joints = self.runs[0].joints
        if joint not in joints:
            hint = did_you_mean(joint, joints)
            raise InputError(f"{self.scenario}: joint: found {joint}; expected one of {', '.join(joints)}{hint}")
        if joint not in self._fitted:
            used = [run for run in self.runs if run.use != "held_out"]
            self._fitted[joint] = shape_of(used or self.runs, joint)
        return self._fitted[joint]

    @property
    def sentences(self) -> list[str]:
        """What the missing effort of every joint depends on, in words."""
        return [sentence(self.shape(joint)) for joint in self.runs[0].joints]

    @property
    def effects(self) -> list[EffectSpec]:
        """All that was found as effects of a scenario, for `simulate(..., effects=...)`."""
        return [effect for joint in self.runs[0].joints for effect in self.shape(joint).effects]

    def to_frame(self) -> pd.DataFrame:
        """One row per recording, joint and sample: effort, its standard error, and all that it may depend on."""
        return pd.concat(
            [
                pd.DataFrame(
                    {
                        "recording": run.name,
                        "joint": joint,
                        "time": run.time,
                        "effort": run.effort[:, j],
                        "effort_error": run.error[:, j],
                        **{name: values[:, j] for name, values in run.variables.items()},
                    }
                )
                for run in self.runs
                for j, joint in enumerate(run.joints)
            ],
            ignore_index=True,
        )


def missing_effort(
    scenario: Source,
    engine: str = "mujoco",
    *,
    runs: str | Sequence[str] = ("*",),
    effects: Effect | Sequence[Effect] = (),
) -> Missing:
    """The effort that would have to be added to every joint for the model to follow the recordings.

    Args:
        scenario: a scenario, the path of one, or a dict that says the same.
        engine: whose dynamics the model has.
        runs: names of recordings, or patterns over them; or one.
        effects: physics that is added to the scenario's own.

    Raises:
        InputError, ModelError: for whatever is wrong with the scenario, its files, or the arguments.
        Unsupported: for a floating base, coupled joints, or what the engine cannot express.
    """
    (name,) = engine_names([engine], "engine")
    file = load_scenario(scenario)
    added = added_effects(file, effects)
    runs = [runs] if isinstance(runs, str) else list(runs)
    found = experiments(file, only=runs, effects=added)
    if not found:
        raise InputError(f"{file.path}: runs: {', '.join(runs)} matches no recording")
    return Missing(file.scenario.name, tuple(missing_of(e, name) for e in found))
