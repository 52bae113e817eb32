"""The committed JSON Schema is that of the code, and every committed config satisfies both."""

import json
from importlib.metadata import entry_points
from pathlib import Path

import jsonschema
import pytest

from wm3d.bench import load_experiment
from wm3d.bench.schema import json_schema
from wm3d.bench.yamlfile import read_yaml

CONFIGS = Path(__file__).parents[2] / "configs"
ALL = sorted(CONFIGS.rglob("*.yaml"))


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    schema = json.loads((CONFIGS / "schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.skipif(
    bool(entry_points(group="wm3d.attacks") or entry_points(group="wm3d.schemes")),
    reason="plug-ins are installed, and the schema knows them",
)
def test_committed_schema_is_current():
    made_by = "python -m wm3d.bench.schema > configs/schema.json"
    assert (CONFIGS / "schema.json").read_text() == json_schema(), f"make it again: {made_by}"


@pytest.mark.parametrize("path", ALL, ids=lambda path: str(path.relative_to(CONFIGS)))
def test_committed_configs_satisfy_the_schema_and_the_code(path, validator):
    validator.validate(read_yaml(path).data)
    load_experiment(path)
    first = path.read_text().splitlines()[0]
    named = first.removeprefix("# yaml-language-server: $schema=")
    assert (path.parent / named).resolve() == CONFIGS / "schema.json"


@pytest.mark.parametrize(
    "change",
    [
        {"trials": 0},
        {"trails": 10},
        {"attacks": [{"percent": 0.6}]},  # no name
        {"attacks": [{"name": "gaussian-noise", "percnt": 0.6}]},
        {"attacks": [{"name": "gaussian-noise", "percent": -1}]},
        {"cases": [{"meshes": ["bunny"], "schemes": [{"name": "song2002", "grid": [84]}]}]},
        {"cases": [{"meshes": [], "schemes": [{"name": "song2002"}]}]},
    ],
    ids=str,
)
def test_schema_refuses_what_the_code_refuses(change, validator):
    data = read_yaml(CONFIGS / "quickstart.yaml").data
    assert validator.is_valid(data)
    assert not validator.is_valid(data | change)


def test_editors_are_told_what_a_field_means(validator):
    properties = validator.schema["properties"]
    assert (
        properties["wrong_keys"]["description"]
        == "Independent wrong keys scored on each attacked marked mesh."
    )
    assert all("description" in field for field in properties.values() if "items" not in field)
