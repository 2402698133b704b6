"""The client for asyncio: the same calls, awaited.

    async with sightline.aio.connect("127.0.0.1:50151") as client:
        hits = await client.scene("engine").cast(rays)

The work of a call, copies of arrays included, is done on threads, so that it does not hold up the event loop.
Cancelling a task cancels its call on the server, too. Arguments, answers and errors are those of sightline.connect().
"""

from .batch import Batch
from .client import Client, connect
from .results import Results
from .scene import Scene
from .update_stream import UpdateStream

__all__ = ["Batch", "Client", "Results", "Scene", "UpdateStream", "connect"]
