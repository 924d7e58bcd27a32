"""``datapackage.json`` beside the tables: a Frictionless Data Package, so that programs know each column's type."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError

from mbd_study.tables.data_dictionary import DICTIONARY

FILE = "datapackage.json"
_TYPES = {"str": "string", "int": "integer", "float": "number", "bool": "boolean"}


def table_schema(name: str, row: type) -> dict[str, Any]:
    """The Table Schema of a table.

    Args:
        name: of the table.
        row: dataclass of its rows.
    """
    columns = [
        {
            "name": field.name,
            "type": _TYPES[str(field.type).removesuffix(" | None")],
            "description": DICTIONARY[name][field.name],
        }
        for field in fields(row)
    ]
    schema: dict[str, Any] = {"fields": columns, "missingValues": [""]}
    if name != "sessions":
        of_session = {"resource": "sessions", "fields": "session"}
        schema["foreignKeys"] = [{"fields": "session", "reference": of_session}]
    return schema


def write_datapackage(folder: Path, tables: Mapping[str, type]) -> None:
    """Describe the CSV tables of a folder.

    Args:
        folder: of the tables.
        tables: row type by name.

    Raises:
        BagError: the folder is described already.
    """
    package = {
        "profile": "tabular-data-package",
        "name": "mapping-by-demonstration-sessions",
        "title": "Sessions of Mapping by Demonstration",
        "resources": [
            {
                "name": name,
                "path": f"{name}.csv",
                "profile": "tabular-data-resource",
                "format": "csv",
                "mediatype": "text/csv",
                "encoding": "utf-8",
                "schema": table_schema(name, row),
            }
            for name, row in tables.items()
        ],
    }
    try:
        with (folder / FILE).open("x", encoding="utf-8") as stream:
            json.dump(package, stream, indent=2, ensure_ascii=False)
            stream.write("\n")
    except FileExistsError as error:
        raise BagError(f"{folder / FILE} exists already and is not overwritten; choose another --out") from error
