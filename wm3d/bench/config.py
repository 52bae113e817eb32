"""The experiment config: what a YAML file may say, checked strictly and all faults at once."""

import json
import math
from pathlib import Path
from typing import Annotated

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
)

from wm3d.attacks import ATTACKS, Attack, Chain
from wm3d.bench.faults import describe_faults
from wm3d.bench.suites import load_suite
from wm3d.bench.yamlfile import Document, read_yaml
from wm3d.component import Component
from wm3d.errors import Wm3dError
from wm3d.metrics import Budget
from wm3d.registry import OneOf
from wm3d.schemes import SCHEMES, Scheme


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def _known_suite(name: str) -> str:
    load_suite(name)
    return name


def _listed(budgets: Budget | tuple[Budget, ...]) -> tuple[Budget, ...]:
    return (budgets,) if isinstance(budgets, Budget) else budgets


def _finite(budgets: Budget | tuple[Budget, ...]) -> Budget | tuple[Budget, ...]:
    for budget in _listed(budgets):
        if not math.isfinite(budget.value):
            raise ValueError(f"{budget.in_words()} cannot be reached")
    return budgets


Budgets = Annotated[
    Annotated[Budget, Tag("budget")] | Annotated[tuple[Budget, ...], Tag("budgets")],
    Discriminator(lambda value: "budgets" if isinstance(value, list | tuple) else "budget"),
    AfterValidator(_finite),
]


class Case(_Strict):
    """Every scheme on every mesh of the lists.

    Attributes
    ----------
    meshes : tuple of str
        Names of the registry (``wm3d data list``) or paths of files, relative to the working directory.
    schemes : tuple of Scheme
    """

    meshes: Annotated[tuple[str, ...], Field(min_length=1)]
    schemes: Annotated[tuple[Annotated[Scheme, OneOf(SCHEMES)], ...], Field(min_length=1)]


class Experiment(_Strict):
    """One experiment: cases × attacks × key trials.

    Attributes
    ----------
    name : str
        Lower-case letters, digits and hyphens; names the default run directory ``runs/NAME``.
    title : str
        Heading of the report.
    seed : int
        Root of all randomness.
    trials : int
        Keys embedded, attacked and scored for each mesh, scheme and attack.
    block : int
        Trials stored in one cell file; a run that is killed loses at most its unfinished cells.
    wrong_keys : int
        Independent wrong keys scored on each attacked marked mesh.
    unmarked : bool
        Whether each trial's key is also scored on the unmarked mesh after the same attack.
    cross_meshes : tuple of str
        Other meshes, named as in `Case`, on which each trial's key is scored after the same attack.
    false_alarm_trials : int
        Random keys, at least, drawn for the Monte Carlo false-alarm curve of each mesh, scheme and attack;
        0 for none.
    pf : tuple of float
        False-alarm probabilities at which tables quote Pd.
    calibrate : Budget or tuple of Budget
        Distortions at which schemes are compared: on each mesh the strength of each scheme is set to meet
        each budget, whatever strength its case names. Without budgets every scheme has the strength it names.
    cases : tuple of Case
    suites : tuple of str
        Lists of attacks that come with wm3d, by name; their attacks are run after those listed.
    attacks : tuple of Attack
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]*$")]
    title: str = ""
    seed: Annotated[int, Field(ge=0)] = 2002
    trials: Annotated[int, Field(ge=1)]
    block: Annotated[int, Field(ge=1)] = 10
    wrong_keys: Annotated[int, Field(ge=0)] = 10
    unmarked: bool = False
    cross_meshes: tuple[str, ...] = ()
    false_alarm_trials: Annotated[int, Field(ge=0)] = 0
    pf: Annotated[tuple[Annotated[float, Field(gt=0, lt=1)], ...], Field(min_length=1)] = (
        1e-3,
        1e-6,
        1e-8,
        1e-12,
    )
    calibrate: Budgets = ()
    cases: Annotated[tuple[Case, ...], Field(min_length=1)]
    suites: Annotated[tuple[Annotated[str, AfterValidator(_known_suite)], ...], Field(exclude=True)] = ()
    attacks: Annotated[tuple[Annotated[Attack, OneOf(ATTACKS)], ...], Field(validate_default=True)] = ()

    @field_validator("attacks")
    @classmethod
    def _with_suites(cls, attacks: tuple[Attack, ...], info: ValidationInfo) -> tuple[Attack, ...]:
        """Append the attacks of the suites, each once: the config as run names every attack itself."""
        suites = info.data.get("suites", ())
        merged = [*attacks, *(attack for suite in suites for attack in load_suite(suite))]
        if not merged and "suites" in info.data:
            raise ValueError("are missing; list one or more, or name suites")
        if Chain() in merged:
            raise ValueError("hold a chain of none; name the attacks of a chain under its `then`")
        return tuple(dict.fromkeys(merged))

    @property
    def budgets(self) -> tuple[Budget, ...]:
        """The budgets of `calibrate`, also where it is one alone."""
        return _listed(self.calibrate)

    @property
    def mesh_names(self) -> list[str]:
        """Every mesh that the experiment needs, once."""
        marked = [name for case in self.cases for name in case.meshes]
        return list(dict.fromkeys([*marked, *self.cross_meshes]))


def load_experiment(path: str | Path, overrides: list[str] | None = None) -> Experiment:
    """Read and check a config file.

    Parameters
    ----------
    path : str or Path
    overrides : list of str, optional
        ``path.to.field=value``, applied before the check; items of lists by index, as in
        ``cases.0.schemes.0.alpha=0.9``.

    Raises
    ------
    Wm3dError
        Naming every fault with its line and path.
    """
    document = read_yaml(path)
    for override in overrides or []:
        document.override(override)
    return _checked(document)


def _checked(document: Document) -> Experiment:
    faults = list(document.faults)
    experiment = None
    try:
        # through JSON, where strictness takes a list for a tuple but not "10" for 10
        experiment = Experiment.model_validate_json(json.dumps(document.data, default=str), strict=True)
    except ValidationError as error:
        faults += describe_faults(error, document, Experiment, _components())
    if faults or experiment is None:
        sentences = [sentence for _, sentence in sorted(faults)]
        count = f"{len(faults)} faults:\n  " if len(faults) > 1 else ""
        raise Wm3dError(f"{document.path}: {count}" + "\n  ".join(sentences))
    return experiment


def _components() -> dict[str, type[Component]]:
    """Every component that a config can hold, by name, to suggest parameter names."""
    from wm3d.imagemarks import DETECTORS, IMAGEMARKS

    return {**ATTACKS, **SCHEMES, **IMAGEMARKS, **DETECTORS}
