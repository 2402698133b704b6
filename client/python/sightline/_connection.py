"""A channel to a server, and calls over it: credentials, retries, deadlines, cancelling."""

from __future__ import annotations

import json
import os
import pathlib
import time
from typing import Any, Iterator

import grpc

from . import _proto, errors
from ._endpoint import Endpoint
from ._retries import Retries
from ._scope import scope
from ._segments import SegmentPool, refusal_of
from ._waiting import read_ahead, result_of

DEFAULT_ENDPOINT = "127.0.0.1:50151"
_LIGHT_TIMEOUT = 60.0  # seconds, for calls that send neither rays nor meshes
_READ_AHEAD = 2  # answers of a stream

# Calls that may be repeated: those that read, and ApplyUpdates, which has a request id.
_REPEATABLE = ("CastRays", "QueryPoints", "GetScene", "ListScenes", "BatchGetNodes", "GetSceneStats",
               "FindMissingBlobs", "GetUploadStatus", "GetServerInfo", "ApplyUpdates", "ReadMesh", "ListDeferredCells",
               "ReadLog", "CoolScene")
# Calls that have had no effect where the server refuses them for now, or that may be repeated if they had one. A refusal
# of others may come after their effect: their answer did not fit among those that are not read yet.
_REPEATED_WHEN_REFUSED = {*_REPEATABLE, "PutScene"}
_RETRY = {"maxAttempts": 4, "initialBackoff": "0.1s", "maxBackoff": "2s", "backoffMultiplier": 2,
          "retryableStatusCodes": ["UNAVAILABLE"]}


def service_config(endpoint: Endpoint) -> str:
    names = []
    for name in _REPEATABLE:
        service, method = _proto.methods[name].path[1:].split("/")
        names.append({"service": service, "method": method})
    config: "dict[str, Any]" = {"methodConfig": [{"name": names, "retryPolicy": _RETRY}]}
    if endpoint.is_balanced():  # a server that drains, or cannot write to its store, is left out
        config["loadBalancingConfig"] = [{"round_robin": {}}]
        config["healthCheckConfig"] = {"serviceName": ""}
    return json.dumps(config)


def _route(request: Any, scene: str, key: str = "") -> "tuple[tuple[str, str], ...]":
    """The scene that a call is about, for balancers that keep the trees of a scene on one server; `key` parts its calls
    further."""
    for field in ("scene", "name"):
        scene = scene or getattr(request, field, "")
    if isinstance(scene, str) and scene and all(" " < c <= "~" for c in scene):
        return (("x-scene", scene), ("x-route-key", key)) if key else (("x-scene", scene),)
    return (("x-route-key", key),) if key else ()


def _read(file: "str | os.PathLike[str] | None") -> "bytes | None":
    return None if file is None else pathlib.Path(file).read_bytes()


class Connection:
    """Threads: any."""

    def __init__(self, endpoint: str, tls_ca: Any, tls_cert: Any, tls_key: Any, token: "str | None",
                 token_file: Any, timeout: "float | None", use_segments: bool = True):
        address = Endpoint(endpoint)
        if (tls_cert is None) != (tls_key is None):
            raise ValueError("tls_cert and tls_key belong together")
        if tls_cert is not None and tls_ca is None:
            raise ValueError("a certificate of the client needs tls_ca, too")
        if token is None:
            read = (_read(token_file) or b"").decode("utf-8", "replace").strip()
            token = read or os.environ.get("SIGHTLINE_TOKEN", "")
        if not all(" " < c <= "~" for c in token):
            raise ValueError("the token has characters other than visible ASCII")
        if token and tls_ca is None and not address.is_local():
            raise errors.Unauthenticated(f"the token is not sent to {endpoint} without encryption: use tls_ca",
                                         "TOKEN_IN_PLAINTEXT")
        self.endpoint = endpoint
        self.timeout = timeout
        self._files, self._token = (tls_ca, tls_cert, tls_key), token
        self._metadata = (("authorization", f"Bearer {token}"),) if token else ()
        self._channel = _open(address, _read(tls_ca), _read(tls_cert), _read(tls_key))
        self.segments = SegmentPool(self, refusal_of(address, use_segments))
        self._callables = {name: self._callable(name) for name in _proto.methods}

    def _callable(self, name: str) -> Any:
        method = _proto.methods[name]
        kind = f"{'stream' if method.client_streaming else 'unary'}_{'stream' if method.server_streaming else 'unary'}"
        # Casts encode and decode their own messages: their columns are the buffers of arrays.
        is_cast = name in ("CastRays", "StreamCastRays", "QueryPoints", "StreamQueryPoints")
        return getattr(self._channel, kind)(
            method.path, request_serializer=None if is_cast else method.request.SerializeToString,
            response_deserializer=None if is_cast else method.response.FromString)

    def call(self, name: str, request: Any, timeout: "float | None" = None, light: bool = True,
             scene: str = "", route_key: str = "") -> Any:
        """A call with one answer; `request` is a message or, for a stream, an iterable of them. `timeout` in seconds;
        None: the connection's. A call that is not light has no limit unless one was set. `scene`: what the call is
        about, if a message does not say it. A call that the server refuses for now is repeated when the server says,
        where that is safe."""
        seconds = self._seconds(timeout, light)
        deadline = None if seconds is None else time.monotonic() + seconds
        retries = Retries(deadline)
        while True:
            rest = None if deadline is None else max(0.0, deadline - time.monotonic())
            try:
                return self._attempt(name, request, rest, _route(request, scene, route_key))
            except errors.ResourceExhausted as error:
                if name not in _REPEATED_WHEN_REFUSED or not retries.wait(error):
                    raise

    def _attempt(self, name: str, request: Any, seconds: "float | None", route: Any) -> Any:
        sent = iter(request) if isinstance(request, list) else request
        call = self._callables[name].future(sent, timeout=seconds, metadata=self._metadata + route)
        current = scope.get()
        if current is not None:
            current.add(call)
        try:
            return result_of(call)
        except grpc.RpcError as error:
            raise errors.of_call(error) from None
        except grpc.FutureCancelledError:
            raise errors.Cancelled("the call was cancelled") from None
        except BaseException:
            call.cancel()
            raise
        finally:
            if current is not None:
                current.remove(call)

    def stream(self, name: str, request: Any, timeout: "float | None" = None, scene: str = "",
               route_key: str = "") -> "Stream":
        """A call with many answers; `timeout` in seconds, None: no limit. `scene` as for call()."""
        metadata = self._metadata + _route(request, scene, route_key)
        return Stream(self._callables[name](request, timeout=timeout, metadata=metadata))

    def begin(self, name: str, request: Any) -> Any:
        """A call with many answers, of gRPC, which ends when it is cancelled or forgotten."""
        return self._callables[name](request, metadata=self._metadata)

    def _seconds(self, timeout: "float | None", light: bool) -> "float | None":
        if timeout is None:
            timeout = self.timeout
        return _LIGHT_TIMEOUT if timeout is None and light else timeout

    def command_options(self, timeout: "float | None") -> "tuple[list[str], dict[str, str]]":
        """Flags and variables of the environment that let the command call the same server in the same way."""
        flags = [f"--endpoint={self.endpoint}"]
        for flag, file in zip(("--tls-ca", "--tls-cert", "--tls-key"), self._files):
            flags += [] if file is None else [f"{flag}={os.path.abspath(file)}"]
        seconds = self.timeout if timeout is None else timeout
        flags += [] if seconds is None else [f"--deadline={seconds}"]
        return flags, {"SIGHTLINE_TOKEN": self._token}

    def close(self) -> None:
        """Ends all calls."""
        self._channel.close()


class Stream:
    """The answers of a call. Leaving the `with` block cancels what is left of it."""

    def __init__(self, call: Any):
        self._call = call
        self._scope = scope.get()

    def __enter__(self) -> "Stream":
        if self._scope is not None:
            self._scope.add(self._call)
        return self

    def __exit__(self, *_: Any) -> None:
        self._call.cancel()
        if self._scope is not None:
            self._scope.remove(self._call)

    def cancel(self) -> None:
        self._call.cancel()

    def __iter__(self) -> "Iterator[Any]":
        """Errors: those of errors.py. A call that only the server cancelled is Unavailable."""
        try:
            yield from read_ahead(self._call, _READ_AHEAD)
        except grpc.RpcError as error:
            if error.code() is grpc.StatusCode.CANCELLED and not (self._scope and self._scope.cancelled):
                if "Locally cancelled" not in (error.details() or ""):
                    raise errors.Unavailable("the server ended the call") from None
            raise errors.of_call(error) from None


def _open(endpoint: Endpoint, ca: "bytes | None", cert: "bytes | None", key: "bytes | None") -> Any:
    options = [
        ("grpc.service_config", service_config(endpoint)),
        ("grpc.primary_user_agent", f"sightline-python/{_proto.version}"),
        ("grpc.max_receive_message_length", -1),
        ("grpc.max_send_message_length", -1),
        # When a server returns, gRPC must find it within the pauses of our own attempts.
        ("grpc.initial_reconnect_backoff_ms", 100),
        ("grpc.max_reconnect_backoff_ms", 2000),
        # A server that is frozen, or gone without a word, is noticed during a call.
        ("grpc.keepalive_time_ms", 15000),
        ("grpc.keepalive_timeout_ms", 5000),
        ("grpc.http2.max_pings_without_data", 0),
        # Channels of one process to one server have a connection each.
        ("grpc.use_local_subchannel_pool", 1),
    ]
    if endpoint.authority():
        options.append(("grpc.default_authority", endpoint.authority()))
    if endpoint.is_local():  # a proxy would send out what must not leave this machine
        options.append(("grpc.enable_http_proxy", 0))
    if ca is None:
        return grpc.insecure_channel(endpoint.target(), options)
    return grpc.secure_channel(endpoint.target(), grpc.ssl_channel_credentials(ca, key, cert), options)
