"""A server before another one, which refuses calls before it passes them on."""

import collections
import threading
from concurrent import futures

import grpc
from sightline import _proto


class Status(grpc.Status):
    """A refusal. `delay`: seconds after which to come back; None: it does not say."""

    def __init__(self, reason, delay):
        status = _proto.message("google.rpc.Status")(code=8, message="come back later")
        info = _proto.message("google.rpc.ErrorInfo")(reason=reason, domain="sightline")
        status.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo", value=info.SerializeToString())
        if delay is not None:
            retry = _proto.message("google.rpc.RetryInfo")()
            retry.retry_delay.seconds, retry.retry_delay.nanos = int(delay), int(delay % 1 * 1e9)
            status.details.add(type_url="type.googleapis.com/google.rpc.RetryInfo", value=retry.SerializeToString())
        self.code, self.details = grpc.StatusCode.RESOURCE_EXHAUSTED, status.message
        self.trailing_metadata = (("grpc-status-details-bin", status.SerializeToString()),)


class Refusing(grpc.GenericRpcHandler):
    """`endpoint` of a server that passes calls on to `target`, but refuses the next `refusals` of each method by name."""

    def __init__(self, target):
        self.refusals = {}
        self.calls = collections.Counter()
        self.refusal = Status("QUEUE_FULL", 0.001)
        self.refused = threading.Event()
        self._channel = grpc.insecure_channel(target, [("grpc.use_local_subchannel_pool", 1)])
        self._server = grpc.server(futures.ThreadPoolExecutor(64))
        self._server.add_generic_rpc_handlers([self])
        self.endpoint = f"127.0.0.1:{self._server.add_insecure_port('127.0.0.1:0')}"
        self._server.start()

    def service(self, details):
        name = details.method.rpartition("/")[2]
        return grpc.stream_stream_rpc_method_handler(
            lambda requests, context: self._serve(details.method, name, requests, context))

    def _serve(self, method, name, requests, context):
        self.calls[name] += 1
        if self.refusals.get(name, 0) > 0:
            self.refusals[name] -= 1
            self.refused.set()
            context.abort_with_status(self.refusal)
        call = self._channel.stream_stream(method)(requests)
        context.add_callback(call.cancel)
        try:
            yield from call
        except grpc.RpcError as error:
            context.set_trailing_metadata(error.trailing_metadata() or ())
            context.abort(error.code(), error.details())

    def close(self):
        self._server.stop(None)
        self._channel.close()
