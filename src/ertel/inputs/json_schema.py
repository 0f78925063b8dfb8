"""The JSON schema of case files, for editors and checkers: keys, kinds of values, meanings, examples.

It takes every file that ertel takes, as far as units are spelled as in `spellings`.  It does not tell which keys belong
together: that is in the rules of the model, and `ertel check` says it.
"""

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from ertel.case.records import law_fields
from ertel.inputs.oil_rheology import OF_OILS
from ertel.inputs.schema import SECTIONS, case_file

DIALECT = "https://json-schema.org/draft/2020-12/schema"


class _WithoutNull(GenerateJsonSchema):
    """TOML has no null: a key is left out.  What then holds is in its meaning, not in the default None."""

    def nullable_schema(self, schema: Any) -> Any:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: Any) -> Any:
        return self.generate_inner(schema["schema"])

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def json_schema() -> dict[str, Any]:
    """The JSON schema of a case file, with the laws and shapes that are registered now."""
    found = case_file().model_json_schema(schema_generator=_WithoutNull)
    for name, part in SECTIONS.items():
        found["$defs"][name.capitalize()]["description"] = part.text
    del found["$defs"]["Thermal"]["required"]  # the named oil and materials may complete it
    laws = found["$defs"]["Lubricant"]["properties"]["rheology"]["oneOf"]
    laws[0] = {
        "type": "string",
        "enum": ["newtonian", *(name for name, (law, _) in OF_OILS.items() if not law_fields(law))],
    }
    for table in found["$defs"].values():
        table.pop("title", None)
        if table["properties"].get("law", {}).get("const") in OF_OILS:  # a named oil may have the rest
            table["required"] = ["law"]
    return {"$schema": DIALECT, **found, "title": "Case file of ertel"}


def json_schema_text() -> str:
    """The JSON schema as a text in ASCII."""
    return json.dumps(json_schema(), indent=2) + "\n"
