"""Validates TOML files against a JSON Schema; prints the message of the first error of each, or null, as JSON."""

import json
import sys
import tomllib
from pathlib import Path

import jsonschema


def main(schema, *files):
    schema = json.loads(Path(schema).read_text())
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    validator = kind(schema)
    found = {}
    for file in files:
        error = next(validator.iter_errors(tomllib.loads(Path(file).read_text())), None)
        found[Path(file).name] = error and f"{error.json_path}: {error.message}"
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main(*sys.argv[1:])
