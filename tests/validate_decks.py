"""Validates decks against their JSON Schemas. Reads a file with the schemas, and decks with the number of their schema; prints
for each deck what is wrong with it, or null."""

import json
import pathlib
import sys

from jsonschema import Draft7Validator

schemas, decks = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
for schema in schemas:
    Draft7Validator.check_schema(schema)
validators = [Draft7Validator(schema) for schema in schemas]
faults = [next(validators[which].iter_errors(deck), None) for which, deck in decks]
print(json.dumps([fault and f"{fault.json_path}: {fault.message[:200]}" for fault in faults]))
