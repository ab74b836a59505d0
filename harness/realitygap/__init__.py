"""realitygap: one scenario through many physics engines, compared with recordings of the real robot.

    import realitygap as rg

    s = rg.load_scenario("scenarios/demo/scenario.yaml")
    t = rg.simulate(s, "mujoco", run="chirp_1", effects=[rg.effects.coulomb_friction("elbow", torque=0.6)])
    t.to_frame()                                         # time x (signal, joint)
    rg.compare(s, engines=["mujoco", "dart"]).gaps       # the table of gaps.csv
    d = rg.diagnose(s)
    d.verdict, d.findings, d.revised.save("fixed/")

Paths are `str` or `Path`. What is raised on purpose is a `RealityGapError`. Every name is imported when it is first
used, so that the import itself costs nothing and changes nothing in the process.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from realitygap_engines import Diverged as Diverged
    from realitygap_engines import Failed as Failed
    from realitygap_engines import ModelError as ModelError
    from realitygap_engines import RealityGapError as RealityGapError
    from realitygap_engines import Unsupported as Unsupported
    from realitygap_engines import available as available
    from realitygap_engines.model.read import read_model as read_model
    from realitygap_engines.model.robot import Model as Model

    from realitygap.compare.library import Compared as Compared
    from realitygap.compare.library import compare as compare
    from realitygap.diagnose.library import Diagnosed as Diagnosed
    from realitygap.diagnose.library import Finding as Finding
    from realitygap.diagnose.library import Revised as Revised
    from realitygap.diagnose.library import diagnose as diagnose
    from realitygap.files.errors import InputError as InputError
    from realitygap.missing.library import Missing as Missing
    from realitygap.missing.library import missing_effort as missing_effort
    from realitygap.recording.recording import Recording as Recording
    from realitygap.robot.effects.library import effects as effects
    from realitygap.scenario.file import ScenarioFile as ScenarioFile
    from realitygap.scenario.file import load_scenario as load_scenario
    from realitygap.scenario.schema import EffectSpec as EffectSpec
    from realitygap.simulate.library import read_run as read_run
    from realitygap.simulate.library import simulate as simulate
    from realitygap.trace.trace import Trace as Trace

_PLACES = {  # name -> the module that holds it
    "Compared": "realitygap.compare.library",
    "Diagnosed": "realitygap.diagnose.library",
    "Diverged": "realitygap_engines",
    "EffectSpec": "realitygap.scenario.schema",
    "Failed": "realitygap_engines",
    "Finding": "realitygap.diagnose.library",
    "InputError": "realitygap.files.errors",
    "Missing": "realitygap.missing.library",
    "Model": "realitygap_engines.model.robot",
    "ModelError": "realitygap_engines",
    "RealityGapError": "realitygap_engines",
    "Recording": "realitygap.recording.recording",
    "Revised": "realitygap.diagnose.library",
    "ScenarioFile": "realitygap.scenario.file",
    "Trace": "realitygap.trace.trace",
    "Unsupported": "realitygap_engines",
    "available": "realitygap_engines",
    "compare": "realitygap.compare.library",
    "diagnose": "realitygap.diagnose.library",
    "effects": "realitygap.robot.effects.library",
    "load_scenario": "realitygap.scenario.file",
    "missing_effort": "realitygap.missing.library",
    "read_model": "realitygap_engines.model.read",
    "read_run": "realitygap.simulate.library",
    "simulate": "realitygap.simulate.library",
}
__all__ = list(_PLACES)

# Three verbs are rooms, too. Importing a room puts it here once, the first time; that is done now and taken away, so
# that the name is the verb whenever it is asked for. `from realitygap.simulate.rollout import ...` finds the room.
for _room in ("compare", "diagnose", "simulate"):
    import_module(f"realitygap.{_room}")
    del globals()[_room]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("realitygap")
    if name not in _PLACES:
        raise AttributeError(f"module 'realitygap' has no {name}; it has {', '.join(_PLACES)}")
    found = getattr(import_module(_PLACES[name]), name)
    globals()[name] = found  # asked once
    return found


def __dir__() -> list[str]:
    return ["__version__", *_PLACES]
