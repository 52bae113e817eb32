"""JSON Schema of config files, for editors that complete and check YAML.

`configs/schema.json` is what ``python -m wm3d.bench.schema`` prints. Where plug-ins are installed, the schema
knows their attacks and schemes too, so it is to be made without them.
"""

import json
import sys
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue

from wm3d.bench.config import Experiment
from wm3d.bench.readings import documented
from wm3d.component import Component

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> str:
    """Return the JSON Schema of a config file as text."""
    schema = {"$schema": DIALECT} | Experiment.model_json_schema(schema_generator=_Documented)
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


class _Documented(GenerateJsonSchema):
    """Describes every field by its line under "Attributes", and wants the name of every component."""

    def model_schema(self, schema: Any) -> JsonSchemaValue:
        model = schema["cls"]
        result = super().model_schema(schema)
        result["description"] = (model.__doc__ or "").partition("\n")[0]
        for name, field in result.get("properties", {}).items():
            field.pop("title", None)
            if about := documented(model, name):
                field["description"] = about
        if issubclass(model, Component):
            result["required"] = ["name", *result.get("required", [])]
        return result


if __name__ == "__main__":
    sys.stdout.write(json_schema())
