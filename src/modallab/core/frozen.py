"""The base of every document, and what its fields may hold: NumPy arrays, finite and positive numbers."""

import inspect
import re
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    PlainSerializer,
    PositiveFloat,
    Strict,
    WithJsonSchema,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[PositiveFloat, Field(allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Frozen(BaseModel):
    """An immutable document that rejects fields it does not know. What its docstring says of its fields, its JSON
    schema says too.

    Attributes:
        renamed: field of an older version -> its name today, so that stored documents stay readable.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
    renamed: ClassVar[Mapping[str, str]] = {}

    @classmethod
    def of_fields(cls, *sources: object, **others: Any) -> Self:
        """A document whose fields are the attributes of that name of the sources, besides those that are given."""
        named = {n: getattr(s, n) for s in sources for n in cls.model_fields if n not in others and hasattr(s, n)}
        return cls(**named, **others)

    @model_validator(mode="before")
    @classmethod
    def _read_renamed(cls, content: object) -> object:
        if not cls.renamed or not isinstance(content, Mapping):
            return content
        fields = cast("Mapping[str, object]", content)
        # A document that holds both names is neither old nor new: the old one is then rejected as any unknown field.
        names = {old: new for old, new in cls.renamed.items() if new not in fields}
        return {names.get(name, name): value for name, value in fields.items()}

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler, /) -> JsonSchemaValue:
        schema = handler(core_schema)
        own = handler.resolve_ref_schema(schema)
        own["description"], of_fields = described_fields(cls)
        for name, text in (_OF_ALL | of_fields).items():
            if name in own.get("properties", {}):
                own["properties"][name].setdefault("description", text)
        return schema


def described_fields(cls: type) -> tuple[str, dict[str, str]]:
    """What a class's docstring says of itself, and what it and those of its bases say of each attribute."""
    fields: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        listed = inspect.cleandoc(base.__doc__ or "").partition(_LIST)[2]
        for names, text in _ATTRIBUTE.findall(listed):
            said = re.sub(r"\s+", " ", text).strip()
            said = re.sub(r"\bNone\b", "null", said[:1].upper() + said[1:])
            fields |= dict.fromkeys((name.strip() for name in names.split(",")), said)
    return (inspect.getdoc(cls) or "").partition(_LIST)[0], fields


_LIST = "\n\nAttributes:\n"
_OF_ALL = {"kind": "Kind of this document.", "format_version": "Version of the document's format."}
_ATTRIBUTE = re.compile(r"^ {4}([A-Za-z][\w, ]*):((?:.*)(?:\n {8}.*)*)", re.MULTILINE)


Truth = Annotated[bool, Strict()]
"""What someone asks for or agrees to: true or false, and neither 1, "yes" nor "on", which may be a slip."""


def is_missing(value: object) -> bool:
    """Whether there is no array: one cannot be compared as `is_not_stated` does."""
    return value is None


def is_not_stated(value: object) -> bool:
    """Whether an optional field holds nothing: then it is not written, as in documents from before there was one."""
    return value is None or value == ()


def _real_array(value: object) -> NDArray[np.float64]:
    # JSON has no NaN: an unknown number is written as null and read back as NaN, as float() does for None in NumPy.
    array = np.array(value, dtype=object).astype(np.float64)
    array.flags.writeable = False
    return array


def _complex_array(value: object) -> NDArray[np.complex128]:
    if isinstance(value, Mapping):
        parts = cast("Mapping[str, object]", value)
        array = _real_array(parts["re"]) + 1j * _real_array(parts["im"])
    else:
        array = np.array(value, dtype=np.complex128)
    array.flags.writeable = False
    return array


def _array_as_lists(array: NDArray[np.float64]) -> list[Any]:
    listed = array.astype(object)
    listed[~np.isfinite(array)] = None
    return listed.tolist()


def _plain_complex(array: NDArray[np.complex128]) -> dict[str, Any]:
    return {"re": _array_as_lists(array.real), "im": _array_as_lists(array.imag)}


_NUMBERS = {"type": "array", "items": {}}

RealArray = Annotated[
    NDArray[np.float64],
    BeforeValidator(_real_array),
    PlainSerializer(_array_as_lists),
    WithJsonSchema(cast("Any", _NUMBERS)),
]
"""A real array; in JSON nested lists, null where unknown."""

ComplexArray = Annotated[
    NDArray[np.complex128],
    BeforeValidator(_complex_array),
    PlainSerializer(_plain_complex),
    WithJsonSchema({"type": "object", "properties": {"re": cast("Any", _NUMBERS), "im": cast("Any", _NUMBERS)}}),
]
"""A complex array; in JSON an object with `re` and `im`."""
