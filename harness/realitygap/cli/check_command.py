"""The command that looks for a person's mistakes before any physics is blamed."""

from pathlib import Path
from typing import Annotated

import typer

from realitygap.cli.options import file_argument


def check(scenario: Annotated[Path, file_argument("the scenario file")]) -> None:
    """Look for mistakes of unit, sign, order, clock and coverage.

    In the scenario, its robot and its recordings, before any physics is blamed. Exits with 2 where one is certain, or
    where `run` refuses the scenario; likely ones are listed. `accept` in the scenario says what is none.
    """
    from realitygap.check import accepted, advice
    from realitygap.check import check as look
    from realitygap.compare.comparison import motions_of
    from realitygap.matrix.plan import Reader
    from realitygap.recording.outliers import told
    from realitygap.recording.sections import unused_keys
    from realitygap.scenario.file import load_scenario

    file, read = load_scenario(scenario), Reader()
    found = look(file, read)
    for m in found:
        certainty = "accepted" if accepted(file, m) else m.certainty
        typer.echo(f"{certainty}: {m.kind}: {m.text}")
    if any(m.certainty == "certain" and not accepted(file, m) for m in found):
        raise typer.Exit(2)
    # a run prepares the motions, too, and refuses what cannot be simulated or judged
    prepared = [e for motion in motions_of(file, read) for e in motion.experiments]
    for name, recording in ((e.name, e.recording) for e in prepared if e.recording is not None):
        for text in (*(lack.text for lack in recording.absent), *told(recording.outliers).values()):
            typer.echo(f"note: {name}: {text}")
    for note in (*unused_keys(file, file.cases()), *advice(file, read)):
        typer.echo(f"note: {note}")
    if not found:
        typer.echo("no mistake found")
