"""What a server says of itself."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Optional, Tuple

from .storage_limits import StorageLimits


@dataclasses.dataclass(frozen=True)
class ServerInfo:
    """What a server says of itself: every limit that a request can meet, and every time after which it ends a call.
    features: such as "closest". simd_target: what the kernels run on. storage: None if scenes are in memory only.
    memory, tree_memory: bytes that the server holds, by what for; trees are one part of the first."""

    version: str
    features: Tuple[str, ...]
    policy: str
    threads: int
    simd_target: str
    storage: Optional[StorageLimits]
    memory: Dict[str, int]
    tree_memory: Dict[str, int]
    tree_pieces_evicted: int  #: subtrees and lists, to keep within the budget
    tree_bytes_evicted: int
    max_message_bytes: int
    max_blob_chunk_bytes: int
    max_rays_per_request: int
    max_rays_queued: int  #: in work on the whole server
    max_bytes_queued: int  #: bytes of requests in work on the whole server
    max_triangles_per_mesh: int  #: faces, lines and points of the file included
    max_depth: int  #: nodes from a root to a leaf
    max_hits_per_ray: int  #: for kind ALL
    max_hits_per_reply: int  #: for CastRays of kind ALL: rays times max_hits
    max_exclusions: int
    max_prefetches: int  #: in work on the whole server
    max_updates_per_batch: int
    max_batch_bytes: int  #: a batch of StreamUpdates; one of ApplyUpdates is one message
    update_window: int  #: batches of StreamUpdates on their way
    max_update_streams: int  #: open on the whole server, like the next two
    max_watches: int
    max_waiting_reads: int  #: reads that wait for a revision
    max_read_wait_ms: int  #: how long each may wait
    max_exact_revisions: int  #: revisions that can be read beside the newest; fewer where they differ much
    max_logged_revisions: int  #: revisions that a watch can begin before; fewer where their updates are large
    max_request_ids: int  #: answers kept for a scene
    max_producers: int  #: names in a scene
    memory_budget_bytes: int  #: all that the server holds: meshes, uploads, nodes, logs, trees, calls
    memory_for_calls_bytes: int  #: the part that is only for calls: requests in work, batches half sent, unread replies
    max_bytes_per_connection: int  #: the part of max_bytes_queued for one connection
    max_bytes_per_principal: int  #: the same for one principal: the caller's name, or its address
    max_batch_bytes_queued: int  #: batches of StreamUpdates that are not applied, on the whole server
    max_unread_bytes: int  #: replies that are not read, on the whole server
    max_unread_bytes_per_connection: int
    max_unread_bytes_per_principal: int
    max_calls_per_connection: int  #: at a time; more wait
    max_cast_streams: int  #: open on the whole server
    max_streams_per_connection: int  #: for each kind: streams of rays, of updates, watches, waiting reads
    max_streams_per_principal: int
    max_upload_calls: int  #: open on the whole server
    max_uploads: int  #: not finished, on the whole server
    max_scenes: int
    idle_stream_ms: int  #: a stream on which its client sends nothing for so long is ended
    idle_gives_way_ms: int  #: a stream that is idle for so long is ended where another call needs its place
    batch_timeout_ms: int  #: a batch of StreamUpdates of which a part has come must go on within this
    upload_timeout_ms: int  #: an upload must get upload_progress_bytes within this
    upload_progress_bytes: int
    idle_upload_ms: int  #: an upload without this progress is dropped where room is needed
    reply_timeout_ms: int  #: a call whose reply is not read within this is cancelled
    watch_progress_ms: int  #: between two messages of a watch
    max_deformed_bytes: int  #: meshes that a batch patches
    max_nodes_per_patch: int
    max_digests_per_request: int  #: for FindMissingBlobs
    max_nodes_per_request: int  #: for BatchGetNodes
    max_scenes_per_page: int
    max_prefetch_roots: int
    max_node_name_bytes: int
    max_request_id_bytes: int
    max_producer_name_bytes: int
    max_id_bytes: int  #: the id of a project or of a scene
    max_rays_all_hits_queued: int  #: in work with kind ALL, until their replies are read
    max_bytes_all_hits_queued: int
    max_rays_small_cast: int  #: casts of up to this number of rays have workers of their own and a reserve
    max_bytes_log: int  #: updates that a scene keeps for watches
    max_bytes_exact_revisions: int  #: what a scene's kept revisions do not share with later ones
    drain_ms: int  #: how long a server that stops waits for open calls
    max_connections: int  #: open on the whole server
    retry_delay_ms: int  #: a call refused with QUEUE_FULL may come back after this; earlier refusals may wait for it
    max_name_bytes_per_reply: int  #: names of nodes in an answer to rays
    max_segment_bytes: int  #: of one segment; 0: the server offers none to this client
    max_segments: int  #: open on the whole server
    max_segments_per_principal: int
    max_rays_per_shared_request: int  #: whose rays and answers are in a segment, or whose rays are made and answers are
    max_labels_per_node: int
    max_label_key_bytes: int
    max_label_value_bytes: int
    max_label_bytes_per_node: int  #: keys and values
    max_label_matches: int  #: labels in `under`, and in `exclude`

    @classmethod
    def of(cls, answer: Any) -> "ServerInfo":
        """The value of a message GetServerInfoResponse."""
        values = {field.name: getattr(answer, field.name) for field in dataclasses.fields(cls)}
        values["features"] = tuple(answer.features)
        values["storage"] = StorageLimits.of(answer.storage) if answer.HasField("storage") else None
        for name in ("memory", "tree_memory"):
            values[name] = {held.kind: held.bytes for held in getattr(answer, name)}
        return cls(**values)
