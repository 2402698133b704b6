"""The messages and services of package sightline.v1, made from descriptors at import.

They live in a descriptor pool of their own, so that no other package's messages clash with them, whatever version of
google.rpc it brings. `_proto.Transform` is the class of sightline.v1.Transform, and so on for each message.
"""

import pathlib
from typing import Any, NamedTuple

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

_FOLDER = pathlib.Path(__file__).parent
PACKAGE = "sightline.v1"

version = (_FOLDER / "version.txt").read_text().strip()
files = descriptor_pb2.FileDescriptorSet.FromString((_FOLDER / "descriptors.binpb").read_bytes())
_pool = descriptor_pool.DescriptorPool()
for _file in files.file:
    _pool.AddSerializedFile(_file.SerializeToString())

if hasattr(message_factory, "GetMessageClass"):
    _class_of = message_factory.GetMessageClass
else:  # before protobuf 4.22
    _class_of = message_factory.MessageFactory(_pool).GetPrototype


class Method(NamedTuple):
    """A call of a service."""

    path: str
    request: Any
    response: Any
    client_streaming: bool
    server_streaming: bool


def message(full_name: str) -> Any:
    """The class of a message."""
    return _class_of(_pool.FindMessageTypeByName(full_name))


def enum_value(name: str) -> int:
    """The number of an enumerator, such as QUERY_KIND_ANY."""
    return _enumerators[name]


def _methods() -> "dict[str, Method]":
    found = {}
    for file in files.file:
        for service in file.service:
            for method in service.method:
                found[method.name] = Method(
                    f"/{file.package}.{service.name}/{method.name}", message(method.input_type[1:]),
                    message(method.output_type[1:]), method.client_streaming, method.server_streaming)
    return found


_enumerators: "dict[str, int]" = {value.name: value.number for file in files.file if file.package == PACKAGE
                for enum in file.enum_type for value in enum.value}
methods = _methods()


def __getattr__(name: str) -> Any:
    try:
        found = message(f"{PACKAGE}.{name}")
    except KeyError:
        raise AttributeError(f"{PACKAGE} has no message {name}") from None
    globals()[name] = found
    return found
