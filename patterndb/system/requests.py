"""Requests: one struct of options that library, command line, HTTP and documentation read.

A subclass of :class:`Request` declares options as fields. The annotation of a field has everything
about it: the type with its range, and :func:`option` with the help text. One more option is one
more field; :func:`list_options` gives the fields to everything that reads requests.
"""

from __future__ import annotations

import numbers
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, cast, get_args, get_origin

import msgspec
from msgspec import Meta, ValidationError
from msgspec.inspect import (
    IntType,
    LiteralType,
    Metadata,
    NoneType,
    StructType,
    TupleType,
    Type,
    UnionType,
    type_info,
)

from patterndb.errors import PatternDBError
from patterndb.system.numbers import MOST_COUNT

#: Types to declare options by; the description names a valid value in messages.
Count = Annotated[int, Meta(ge=0, le=MOST_COUNT, description="a whole number from 0")]
Positive = Annotated[int, Meta(ge=1, le=MOST_COUNT, description="a whole number from 1")]
Range = Annotated[tuple[Count, Count], Meta(description="two numbers, [least, greatest]")]
Seconds = Annotated[float, Meta(gt=0, le=1e6, description="seconds, more than 0")]
Text = Annotated[str, Meta(max_length=256, description="a text of at most 256 characters")]
#: More threads than this help no search.
Threads = Annotated[int, Meta(ge=1, le=1024, description="a whole number from 1 to 1,024")]
Texts = Annotated[tuple[Text, ...], Meta(max_length=64)]

R = TypeVar("R", bound="Request")


@dataclass(frozen=True, slots=True)
class OptionText:
    """How an option is written and described.

    help: what it does, as the help of a command shows it.
    flag: its name on the command line, both names of a flag: "--strict/--relaxed". The field's name
        if empty.
    metavar: the placeholder for the value in the help.
    hint: the end of the message about an invalid value.
    section: the part of a command's help that it belongs to.
    constant: the value that a flag of the command line stands for; None for other options.
    default: what is taken where it is left out, if that is not a value that can be written.
    """

    help: str
    flag: str = ""
    metavar: str = ""
    hint: str = ""
    section: str = ""
    constant: object = None
    default: str = ""


def option(help: str, *, rule: object = None, **text: Any) -> Meta:
    """Annotate a field of a request as an option; text: see :class:`OptionText`.

    rule: what the option means to those that answer the request, kept as :attr:`Option.rule`.
    """
    return Meta(extra={"text": OptionText(help, **text), "rule": rule})


@dataclass(frozen=True, slots=True)
class Option:
    """An option of a request.

    name: the field's. annotation: the type that the field is declared with.
    type: the same as msgspec inspects it, without descriptions and None; where words or a number
        may be given, that of the number.
    optional: may it be None? default: its value where it is left out.
    """

    name: str
    annotation: Any
    type: Type
    optional: bool
    default: Any
    text: OptionText
    rule: Any

    @property
    def flag(self) -> str:
        """Its name on the command line; both names, with a slash, of a flag with two."""
        return self.text.flag or "--" + self.name.replace("_", "-")

    @property
    def choices(self) -> tuple[str, ...]:
        """The values of a choice, in the order of their declaration; empty for other options."""
        return _find_choices(self.annotation)

    def convert(self, value: object, error: type[PatternDBError]) -> object:
        """Return a valid value as the field has it: lists and sets become tuples.

        Raises ``error`` for an invalid one.
        """
        if not isinstance(value, bool) and isinstance(value, numbers.Integral):
            value = int(value)
        try:
            found = msgspec.convert(value, self.annotation)
        except ValidationError:
            raise error(self._explain(value)) from None
        if isinstance(self.type, TupleType) and found is not None and found[0] > found[1]:
            raise error(self._explain(value))
        return found

    def _explain(self, value: object) -> str:
        whole = self.type
        found = cast("tuple[object, ...]", value if isinstance(value, tuple) else (value,))
        if isinstance(whole, TupleType):
            whole = strip_type(whole.item_types[-1])
        most = whole.le if isinstance(whole, IntType) else None
        if most is not None and any(isinstance(one, int) and one > most for one in found):
            return f"{self.name} is more than {most:,}, the most; give less"
        hint = self.text.hint
        if not hint and isinstance(self.type, LiteralType):
            hint = f"there are {', '.join(self.choices)}"
        if not hint and isinstance(self.type, IntType) and self.type.ge is not None:
            hint = f"the least is {self.type.ge}"
            hint += ", None leaves it open" if self.optional else ""
        return f"{self.name} is {value!r}; {hint or 'see its documentation'}"


class Request(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Options of a question; subclasses declare them.

    Creating one raises its ``error`` for an invalid value.
    """

    error: ClassVar[type[PatternDBError]] = PatternDBError

    def __post_init__(self) -> None:
        for name, one in list_options(type(self)).items():
            value = getattr(self, name)
            if value is not one.default:
                found = one.convert(value, self.error)
                if found is not value:
                    msgspec.structs.force_setattr(self, name, found)

    def having(self, **options: Any) -> Self:
        """Return the request with other options in place of its own; raises ``error`` as well."""
        return msgspec.structs.replace(self, **options)


def make_request(kind: type[R], request: R | None, options: Mapping[str, Any]) -> R:
    """Return a request with options, or the one that is given with these options instead.

    Raises TypeError for an option that there is not, and the error of the request for an invalid
    value.
    """
    unknown = sorted(options.keys() - set(kind.__struct_fields__))
    if unknown:
        known = ", ".join(kind.__struct_fields__)
        raise TypeError(f"there is no option {unknown[0]!r}; options are {known}")
    if request is None:
        return kind(**options)
    return request.having(**options) if options else request


def list_changed(request: Request) -> dict[str, Any]:
    """Return the options of a request that differ from their defaults."""
    return {
        name: value
        for name, one in list_options(type(request)).items()
        if (value := getattr(request, name)) != one.default
    }


@cache
def list_options(kind: type[Request]) -> dict[str, Option]:
    """Return the options of a kind of request by name, in the order of their fields.

    Fields without :func:`option` are no options, and are left out.
    """
    annotations = {field.name: field.type for field in msgspec.structs.fields(kind)}
    found: dict[str, Option] = {}
    for field in cast("StructType", type_info(kind)).fields:
        declared = field.type
        extra: dict[str, Any] = {}
        while isinstance(declared, Metadata):
            extra = {**(cast("Any", declared).extra or {}), **extra}
            declared = declared.type
        if "text" not in extra:
            continue
        types = declared.types if isinstance(declared, UnionType) else (declared,)
        bare = [one for one in map(strip_type, types) if not isinstance(one, NoneType)]
        bare.sort(key=lambda one: isinstance(one, LiteralType))
        found[field.name] = Option(
            name=field.name,
            annotation=annotations[field.name],
            type=bare[0],
            optional=len(bare) < len(types),
            default=field.default,
            text=extra["text"],
            rule=extra["rule"],
        )
    return found


def _find_choices(annotation: Any) -> tuple[str, ...]:
    if get_origin(annotation) is Literal:
        return get_args(annotation)
    return next((found for one in get_args(annotation) if (found := _find_choices(one))), ())


def strip_type(kind: Type) -> Type:
    """Return a type without its descriptions."""
    while isinstance(kind, Metadata):
        kind = kind.type
    return kind
