"""One exception class for each gRPC status.

Each is a SightlineError, with `.message` for people, `.reason` for programs (as listed in docs/wire.md; empty where the
error is not the server's), `.metadata` of the reason, and `.code`, the status. Some are also the built-in exception
that says the same: InvalidArgument is a ValueError, NotFound a LookupError, DeadlineExceeded a TimeoutError,
Unavailable a ConnectionError, PermissionDenied a PermissionError.
"""

from __future__ import annotations

from typing import Any, Mapping

import grpc

from . import _proto

_DETAILS = "grpc-status-details-bin"


class SightlineError(Exception):
    """A call that failed."""

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN

    def __init__(self, message: str, reason: str = "", metadata: "Mapping[str, str] | None" = None):
        super().__init__(message)
        self.message = message
        self.reason = reason
        self.metadata = dict(metadata or {})
        #: Seconds after which the server says that the call may be repeated; None: it does not say so. Where that is safe
        #: calls were repeated for a minute before this error is raised.
        self.retry_delay: "float | None" = None

    def __str__(self) -> str:
        return f"{self.message} [{self.reason}]" if self.reason else self.message

    def __reduce__(self) -> Any:
        return type(self), (self.message, self.reason, self.metadata)


class Cancelled(SightlineError):
    """The caller cancelled."""

    code = grpc.StatusCode.CANCELLED


class Unknown(SightlineError):
    """An error without a known status."""


class InvalidArgument(SightlineError, ValueError):
    """The request is invalid."""

    code = grpc.StatusCode.INVALID_ARGUMENT


class DeadlineExceeded(SightlineError, TimeoutError):
    """The call took longer than its timeout."""

    code = grpc.StatusCode.DEADLINE_EXCEEDED


class NotFound(SightlineError, LookupError):
    """There is no such scene or node."""

    code = grpc.StatusCode.NOT_FOUND


class AlreadyExists(SightlineError):
    """The scene exists."""

    code = grpc.StatusCode.ALREADY_EXISTS


class PermissionDenied(SightlineError, PermissionError):
    """The token does not allow the call."""

    code = grpc.StatusCode.PERMISSION_DENIED


class ResourceExhausted(SightlineError):
    """A limit of the server is reached."""

    code = grpc.StatusCode.RESOURCE_EXHAUSTED


class FailedPrecondition(SightlineError):
    """Another call must come first."""

    code = grpc.StatusCode.FAILED_PRECONDITION


class Aborted(SightlineError):
    """The scene is at another revision, or another call took over."""

    code = grpc.StatusCode.ABORTED


class OutOfRange(SightlineError):
    """A revision that is not kept, or not there yet."""

    code = grpc.StatusCode.OUT_OF_RANGE


class Unimplemented(SightlineError):
    """The server does not have this call."""

    code = grpc.StatusCode.UNIMPLEMENTED


class Internal(SightlineError):
    """The server, or what lies between, is at fault."""

    code = grpc.StatusCode.INTERNAL


class Unavailable(SightlineError, ConnectionError):
    """The server cannot be reached, starts, stops, or its store fails."""

    code = grpc.StatusCode.UNAVAILABLE


class DataLoss(SightlineError):
    """Stored or sent bytes are damaged."""

    code = grpc.StatusCode.DATA_LOSS


class Unauthenticated(SightlineError):
    """The server does not know the caller, or its certificate does not convince."""

    code = grpc.StatusCode.UNAUTHENTICATED


_CLASSES = {cls.code: cls for cls in SightlineError.__subclasses__()}


def of_code(number: int, message: str, reason: str = "") -> SightlineError:
    """The error with the number of a status."""
    for code, cls in _CLASSES.items():
        if code.value[0] == number:
            return cls(message, reason)
    return Unknown(message, reason)


def of_name(name: str, message: str, reason: str = "") -> SightlineError:
    """The error with the name of a status, such as NOT_FOUND."""
    for code, cls in _CLASSES.items():
        if code.name == name:
            return cls(message, reason)
    return Unknown(message, reason)


def of_call(error: Any) -> SightlineError:
    """The error that a grpc.RpcError stands for."""
    code, message = error.code(), error.details() or ""
    if code is grpc.StatusCode.UNIMPLEMENTED and not message:
        message = "the server is of a version that does not have this call"
    if code is grpc.StatusCode.UNAVAILABLE and _tells_of_tls(message):
        return Unauthenticated(message, "TLS_FAILED")
    info, retry = _detail(error, "google.rpc.ErrorInfo"), _detail(error, "google.rpc.RetryInfo")
    told = _CLASSES.get(code, Unknown)(message, info.reason if info else "", info.metadata if info else None)
    if retry is not None:
        told.retry_delay = retry.retry_delay.seconds + retry.retry_delay.nanos * 1e-9
    return told


def _detail(error: Any, name: str) -> Any:
    """The first message of this type in the details of a status, or None."""
    for key, value in error.trailing_metadata() or ():
        if key != _DETAILS:
            continue
        for detail in _proto.message("google.rpc.Status").FromString(value).details:
            if detail.type_url.endswith("/" + name):
                return _proto.message(name).FromString(detail.value)
    return None


def _tells_of_tls(message: str) -> bool:
    return "handshake failed" in message or "not in peer certificate" in message
