"""What a run would do and how long it would take, from one real trial of each mesh, scheme and attack."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numba.core import event
from rich.table import Table

from wm3d.bench.columns import NOT_MARKED
from wm3d.bench.plan import CalibrationCell, Cell, FalseAlarmCell, Task, TrialCell, tasks, uncalibrated
from wm3d.bench.progress import duration
from wm3d.bench.summary import table_console
from wm3d.bench.trial import THRESHOLDS
from wm3d.bench.worker import work
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes import Scheme
from wm3d.stats import hadamard_keys

SAMPLE_KEYS = 1 << 22
"""Random keys that are timed to tell what one costs."""

EMBEDDINGS = 10
"""Marked meshes that a calibration makes and measures, about; a measurement takes as long as a reading."""

USUAL_SIGNS = 2000
"""Signs that are timed for a scheme whose number of signs depends on the mesh."""

Setting = tuple[str, str, str]
"""Mesh, scheme and attack, by their labels."""


@dataclass(frozen=True)
class Cost:
    """Seconds that a trial takes to embed, to attack and to read; `error` where one of these went wrong."""

    embed: float
    attack: float
    read: float
    error: str

    @property
    def failure(self) -> str:
        """What became of the trial in one word, if anything did."""
        refused = self.error.startswith(NOT_MARKED)
        return "refused" if refused else "failed" if self.error else ""

    @property
    def trial(self) -> float:
        """Seconds of one trial whose mark is embedded for it alone."""
        return self.embed + self.attack + self.read


def print_estimate(
    name: str, cells: list[Cell], missing: list[Cell], meshes: Mapping[str, Mesh], workers: int
) -> None:
    """Print the plan, what of it is there, and the time that the rest needs."""
    costs = measured(missing, meshes)
    console = table_console()
    schemes = dict.fromkeys(setting(cell)[:2] for cell in cells)
    for mesh, scheme in schemes:
        console.print(f"{mesh}, {scheme}", highlight=False, soft_wrap=True)
        console.print(_table(mesh, scheme, cells, missing, costs))
        errors = [cost.error for names, cost in costs.items() if names[:2] == (mesh, scheme) and cost.error]
        for error in dict.fromkeys(errors):
            console.print(f" {error}", highlight=False, markup=False, soft_wrap=True)
    todo = tasks(missing)
    console.print(
        f"{name}: {len(cells)} cells, {len(cells) - len(missing)} of them there already.", highlight=False
    )
    if todo:
        busy = min(workers, len(todo))
        console.print(
            f"The rest takes about {duration(seconds(todo, costs) / busy)} on {busy} "
            f"worker{'s' if busy > 1 else ''}, from one trial of each kind.",
            highlight=False,
        )


def _table(
    mesh: str, scheme: str, cells: list[Cell], missing: list[Cell], costs: Mapping[Setting, Cost]
) -> Table:
    output = Table(box=None, padding=(0, 1))
    output.add_column("attack")
    for heading in ("cells", "there", "trials", "s a trial"):
        output.add_column(heading, justify="right", no_wrap=True)
    absent = {cell.digest for cell in missing}
    groups: dict[str, list[Cell]] = {}
    for cell in cells:
        if setting(cell)[:2] == (mesh, scheme):
            kind = "calibration" if isinstance(cell, CalibrationCell) else cell.attack.label()
            groups.setdefault(kind, []).append(cell)
    for kind, group in groups.items():
        there = sum(cell.digest not in absent for cell in group)
        cost = None if kind == "calibration" else costs.get(setting(group[0]))
        took = "" if cost is None else cost.failure or f"{cost.trial:.2f}"
        trials = sum(cell.trials for cell in group)
        output.add_row(kind, str(len(group)), str(there), str(trials), took)
    return output


def setting(cell: Cell) -> Setting:
    """Return what a trial's cost depends on: not on the strength that meets a budget."""
    scheme = uncalibrated(cell.scheme) if cell.budget else cell.scheme
    return cell.mesh, scheme.label(), cell.attack.label()


def measured(cells: Iterable[Cell], meshes: Mapping[str, Mesh]) -> dict[Setting, Cost]:
    """Run trial 0 of each setting of the cells, and return what it took; nothing is stored."""
    costs: dict[Setting, Cost] = {}
    for cell in cells:
        if setting(cell) in costs:
            continue
        block = (cell.seed, cell.mesh, cell.mesh_digest, cell.scheme, cell.attack, 0, 1)
        trial = TrialCell(*block, "H1", getattr(cell, "wrong_keys", 0))
        with event.install_recorder("numba:compile") as compiled:
            cost = _timed(trial, meshes)
        again = compiled.buffer or not costs  # what was compiled, or loaded first, is no cost of a trial
        costs[setting(cell)] = _timed(trial, meshes) if again else cost
    return costs


def _timed(trial: TrialCell, meshes: Mapping[str, Mesh]) -> Cost:
    start = time.perf_counter()
    rows = work(meshes, Task((trial,)))
    total = time.perf_counter() - start
    if trial.digest not in rows:
        return Cost(0.0, 0.0, total, "not enough memory")
    row = rows[trial.digest].iloc[0]
    stages = row[["embed_seconds", "attack_seconds"]].to_numpy(np.float64)
    embed, attack = np.nan_to_num(stages).tolist()  # NaN where it never came to that stage
    failed = np.isnan(row["log10_p"]) or row["error"].startswith(NOT_MARKED)
    return Cost(embed, attack, total - embed - attack, str(row["error"]) if failed else "")


def seconds(todo: Iterable[Task], costs: Mapping[Setting, Cost]) -> float:
    """Return the seconds that one worker needs for some tasks."""
    keys: dict[str, float] = {}
    total = 0.0
    for task in todo:
        first = task.cells[0]
        if isinstance(first, CalibrationCell):
            total += EMBEDDINGS * (costs[setting(first)].embed + costs[setting(first)].read)
            continue
        total += (first.stop - first.start) * costs[setting(first)].embed
        for cell in task.cells:
            cost = costs[setting(cell)]
            once = not cell.marked and not cell.attack.random
            total += (1 if once else cell.trials) * (cost.attack + cost.read)
            if isinstance(cell, FalseAlarmCell):
                label = cell.scheme.label()
                keys[label] = keys.get(label) or _seconds_a_key(cell.scheme)
                total += cell.keys * keys[label]
    return total


def _seconds_a_key(scheme: Scheme) -> float:
    try:
        signs = scheme.capacity
    except Wm3dError:  # known once a mesh is marked
        signs = USUAL_SIGNS
    weights = np.linspace(0.5, 1.5, signs)
    hadamard_keys(weights, THRESHOLDS, 1)  # loads the kernel
    start = time.perf_counter()
    hadamard_keys(weights, THRESHOLDS, SAMPLE_KEYS)
    return (time.perf_counter() - start) / SAMPLE_KEYS
