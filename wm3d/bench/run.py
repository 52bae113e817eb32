"""One experiment from config to figures: plan, run what is missing, report what is there."""

import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

from wm3d.bench.cluster import check_scheduler
from wm3d.bench.columns import COLUMNS, LOST, TRY_AGAIN
from wm3d.bench.config import Experiment, load_experiment
from wm3d.bench.estimate import print_estimate
from wm3d.bench.execute import default_workers, execute
from wm3d.bench.manifest import manifest
from wm3d.bench.plan import CalibrationCell, Cell, TrialCell, calibrations, plan, tasks
from wm3d.bench.progress import reporter
from wm3d.bench.report import read_manifest, report_of
from wm3d.bench.store import DamagedCellError, RunDirectory
from wm3d.bench.summary import print_summary
from wm3d.bench.yamlfile import write_yaml
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, datasets


@dataclass(frozen=True)
class Outcome:
    """What a run left behind.

    Attributes
    ----------
    directory : Path
        The run directory.
    failed : int
        Attacked meshes whose attack raised an error, or whose worker died or ran out of memory.
    """

    directory: Path
    failed: int


def run_config(
    path: str | Path,
    *,
    out: Path | None = None,
    workers: int | None = None,
    dask: str | None = None,
    overrides: list[str] | None = None,
    dry_run: bool = False,
) -> Outcome:
    """Run an experiment config; what an earlier run of the same cells left in the directory is kept.

    Cells that met an error that wm3d did not foresee are run again.

    Parameters
    ----------
    path : str or Path
        YAML file, see `Experiment`.
    out : Path, optional
        Run directory; ``runs/NAME`` by default.
    workers : int, optional
        Local processes; as many as processors by default.
    dask : str, optional
        Address of a Dask scheduler to use instead of local processes.
    overrides : list of str, optional
        ``path.to.field=value``.
    dry_run : bool
        Print the plan and how long it would take, from one trial of each mesh, scheme and attack; store
        nothing.

    Raises
    ------
    Wm3dError
        If the config, a mesh or the run directory cannot be used.
    """
    experiment = load_experiment(path, overrides)
    directory = RunDirectory(out or Path("runs") / experiment.name)
    workers = workers or default_workers()
    if _is_own_copy(path, directory):
        raise Wm3dError(f"{path}: would be replaced by the config as run; choose another --out.")
    meshes = _resolved(experiment, path)
    first = calibrations(experiment, meshes)
    if dry_run:
        settled = [cell for cell in first if _held(cell, directory)]
        cells = [*first, *plan(experiment, meshes, _strengths(settled, directory))]
        missing = [cell for cell in cells if not _held(cell, directory)]
        print_estimate(experiment.name, cells, missing, meshes, workers)
        return Outcome(directory.path, 0)
    if dask is not None:
        check_scheduler(dask)  # before the report of an earlier run goes
    directory.create()
    with directory.locked():
        started, earlier = datetime.now(UTC), _reported(directory)
        directory.begin(write_yaml(experiment.model_dump(mode="json")))
        lost = _run_missing(first, meshes, directory, workers, dask) if first else []
        cells = plan(experiment, meshes, _strengths(first, directory))
        if earlier and earlier.isdisjoint(cell.digest for cell in cells):
            print(
                f"{directory.path}: held a run of other trials; its cells are kept, its tables and report "
                "give way to those of this one.",
                file=sys.stderr,
            )
        lost += _run_missing(cells, meshes, directory, workers, dask)
        lost_trials = sum(cell.trials for cell in lost)
        directory.write_text(
            "manifest.json", manifest(experiment, meshes, [*first, *cells], started, lost_trials)
        )
        report = report_of(directory)
        print_summary(report.tables, directory.path, report.refused, report.pf)
    beside = sum(cell.trials for cell in lost if cell.kind != TrialCell.kind)  # no trials of the report
    return Outcome(directory.path, report.failed + beside)


def _reported(directory: RunDirectory) -> set[str]:
    """Return the digests of the trials that the report is about; none where no run was finished."""
    with suppress(Wm3dError):
        return set(read_manifest(directory)["cells"])
    return set()


def _is_own_copy(config: str | Path, directory: RunDirectory) -> bool:
    """Tell whether a config is where the run would store it, in a folder that is no run directory yet."""
    stored = directory.path / "config.yaml"
    return stored.exists() and stored.samefile(config) and not (directory.path / "cells").exists()


def _resolved(experiment: Experiment, config: str | Path) -> dict[str, Mesh]:
    """Return the meshes of an experiment by name; all that cannot be had are told at once."""
    meshes, faults = {}, []
    for name in experiment.mesh_names:
        try:
            meshes[name] = datasets.resolve(name)
        except Wm3dError as error:
            faults.append(str(error))
            if not Path(name).exists() and (Path(config).parent / name).is_file():
                faults[-1] += f" Paths are relative to the folder that the command runs in, {Path.cwd()}."
    if faults:
        count = f"{len(faults)} faults:\n  " if len(faults) > 1 else ""
        raise Wm3dError(f"{config}: {count}" + "\n  ".join(faults))
    return meshes


def _strengths(calibrated: list[Cell], directory: RunDirectory) -> dict[str, float]:
    """Return the strengths that the directory holds, by the digest of their calibration."""
    held = {cell.digest: _rows(cell, directory) for cell in calibrated}
    return {digest: float(rows["strength"].iloc[0]) for digest, rows in held.items() if rows is not None}


def _run_missing(
    cells: list[Cell], meshes: Mapping[str, Mesh], directory: RunDirectory, workers: int, dask: str | None
) -> list[Cell]:
    """Run the cells that the directory does not hold; return those that were lost."""
    missing = [cell for cell in cells if not _held(cell, directory)]
    todo = tasks(missing)
    if len(missing) < len(cells):
        print(f"{len(cells) - len(missing)} of {len(cells)} cells are there already.", file=sys.stderr)
    lost: list[Cell] = []
    with reporter(len(missing), sum(cell.trials for cell in missing)) as progress:
        for task, rows in execute(todo, meshes, workers, dask):
            for cell in task.cells:
                directory.write_cell(cell.digest, rows[cell.digest])
            lost += [cell for cell in task.cells if rows[cell.digest].attrs.get(LOST)]
            progress.advance(len(task.cells), task.trials)
    _tell_lost(lost)
    return lost


def _tell_lost(cells: Iterable[Cell]) -> None:
    """Say which trials failed because their worker died or ran out of memory."""
    lost: dict[tuple[str, str, str], int] = {}
    for cell in cells:
        what = cell.kind if cell.kind == CalibrationCell.kind else cell.attack.label()
        names = (cell.mesh, cell.label, what)
        lost[names] = lost.get(names, 0) + cell.trials
    for names, trials in lost.items():
        count = "1 trial is" if trials == 1 else f"{trials} trials are"
        print(
            f"{', '.join(names)}: {count} lost, for the worker died or ran out of memory each time; run "
            "again to retry, with fewer --workers if memory is short.",
            file=sys.stderr,
        )


def _held(cell: Cell, directory: RunDirectory) -> bool:
    rows = _rows(cell, directory)
    return rows is not None and not rows.attrs.get(TRY_AGAIN)


def _rows(cell: Cell, directory: RunDirectory) -> pd.DataFrame | None:
    """Return the rows of a cell, None if there are none that can be used."""
    try:
        return directory.read_cell(cell.digest, COLUMNS[cell.kind])
    except DamagedCellError as error:
        print(error, file=sys.stderr)
        return None
