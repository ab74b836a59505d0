"""Commands that look for what a model lacks."""

from pathlib import Path
from typing import Annotated

import typer

from realitygap.cli.options import RUNS, Engines, Jobs, file_argument, folder_for, named_after, out_option, say
from realitygap.diagnose.search_budget import EACH, MINUTES


def diagnose(
    scenario: Annotated[Path, file_argument("the scenario file")],
    engine: Engines = None,
    out: Annotated[Path | None, out_option(f"{RUNS}/NAME_diagnosis, after the file's folder")] = None,
    jobs: Jobs = None,
    mjcf: Annotated[bool, typer.Option("--mjcf", help="write the mended model as a MJCF file, too")] = False,
    minutes: Annotated[
        float | None,
        typer.Option(
            "--minutes",
            min=0.0,
            help="how many minutes, by the clock, to look for more; then the search stops, and what it found by then "
            "is judged on held-out runs and written, which takes a little longer; inf: until nothing more is found",
            show_default=f"as many simulations as take about {MINUTES:g} minutes, or {60 * EACH:g} s for every joint",
        ),
    ] = None,
) -> None:
    """Find what a model lacks, add it, prove that it helps.

    Where simulation and measurement disagree, which effect explains it, and the gap on held-out runs.
    """
    from realitygap.diagnose.data.processes import started

    folder = folder_for(out, f"{named_after(scenario)}_diagnosis", "diagnose")
    with started(jobs if scenario.is_file() else 1) as ahead:  # they load their packages while this one loads its own
        from realitygap.diagnose.result.summary import summary
        from realitygap.diagnose.result.workflow import run_diagnosis
        from realitygap.files.progress import Progress

        result = run_diagnosis(scenario, engine or [], folder, Progress(), jobs, ahead, minutes)
    lines = [*summary(result), f"diagnosis: {folder / 'diagnosis.json'}", f"report: {folder / 'report.html'}"]
    if mjcf:
        from realitygap.diagnose.result.revise import MJCF, REVISED, SCENARIO
        from realitygap.diagnose.result.story import write_story
        from realitygap.files.own_files import content, own
        from realitygap.robot.mjcf_file import write_scenario_mjcf

        mended = folder / REVISED / SCENARIO
        lines += write_scenario_mjcf(mended if mended.exists() else scenario, folder / REVISED / MJCF)
        written = own(folder, content(folder / "diagnosis.json").get("revised"), (f"{REVISED}/*",))
        write_story(result, folder, [*written, f"{REVISED}/{MJCF}"])  # once more, with a link to it
    say(lines)


def rehearse(
    scenario: Annotated[Path, file_argument("the scenario file")],
    engine: Engines = None,
    out: Annotated[Path | None, out_option(f"{RUNS}/NAME_rehearsal, after the file's folder")] = None,
    budget: Annotated[float, typer.Option("--budget", help="seconds that it may take, about")] = 300.0,
    jobs: Jobs = None,
) -> None:
    """Say which effects recordings could reveal.

    Each effect is planted in the scenario's own motions: from which size on it shows, what it is taken for, and
    what full searches name of it, as far as the time reaches.
    """
    from realitygap.diagnose.rehearse.files import summary, write_rehearsal
    from realitygap.diagnose.rehearse.rehearse import run_rehearsal
    from realitygap.files.progress import Progress

    folder = folder_for(out, f"{named_after(scenario)}_rehearsal", "rehearse")
    result = run_rehearsal(scenario, engine or [], Progress(), budget, jobs)
    write_rehearsal(result, folder)
    say([*summary(result), f"rehearsal: {folder / 'rehearsal.json'}", f"report: {folder / 'report.html'}"])


def propose(
    path: Annotated[Path, file_argument("the scenario file, or what a diagnosis of it wrote")],
    engine: Engines = None,
    out: Annotated[Path | None, out_option(f"{RUNS}/NAME_proposal, after the file's folder")] = None,
    seconds: Annotated[float, typer.Option("--seconds", help="that a motion may take")] = 20.0,
    motions: Annotated[int, typer.Option("--motions", min=1, help="how many at most")] = 3,
    jobs: Jobs = None,
) -> None:
    """Propose motions that tell apart what the recordings cannot.

    Each as keyframes, commands and a trajectory, within the robot's limits, with the odds that it is expected to give.
    """
    from realitygap.diagnose.propose.files import summary, write_proposal
    from realitygap.diagnose.propose.propose import run_proposal
    from realitygap.files.progress import Progress

    name = path.resolve().name if path.is_dir() else named_after(path)
    folder = folder_for(out, f"{name}_proposal", "propose")
    result = run_proposal(path, engine or [], seconds, motions, Progress(), jobs)
    write_proposal(result, folder)
    if result.ended is not None:
        result.ended.left = f"the best so far is in {folder}"
        raise result.ended
    say([*summary(result), f"proposal: {folder / 'proposal.json'}", f"report: {folder / 'report.html'}"])
