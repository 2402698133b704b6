"""A connection to a server: its scenes, made, listed and deleted."""

from __future__ import annotations

import os
from typing import Any, Iterator, List, Optional

import numpy as np

from . import _backup, _import_file, _proto, errors, updates
from ._connection import DEFAULT_ENDPOINT, Connection
from ._lattice import Lattice
from ._programs import find_program
from ._session import Session
from ._types import Path, Progress
from .backup_scene import BackupScene
from .batch import apply
from .log_lines import LogLines
from .meshes import as_mesh, upload
from .nodes import translation
from .restored_scene import RestoredScene
from .scene import Scene
from .scene_info import SceneInfo
from .server_info import ServerInfo
from .shared_memory import SharedMemory, Transport
from .updates import put_node

_UP = {None: 0, "y": 1, "z": 2}


def connect(endpoint: Optional[str] = None, *, tls_ca: Optional[Path] = None, tls_cert: Optional[Path] = None,
            tls_key: Optional[Path] = None, token: Optional[str] = None, token_file: Optional[Path] = None,
            timeout: Optional[float] = None, use_segments: bool = True) -> "Client":
    """A client of the server at `endpoint`, HOST:PORT, HOST:PORT,HOST:PORT... of replicas that take turns, or
    unix:PATH; default: SIGHTLINE_ENDPOINT, else 127.0.0.1:50151.

    tls_ca, tls_cert, tls_key: PEM files. With tls_ca the connection is encrypted, and the server needs a certificate of
    its name that one of these has signed; the others are this client's own. token, or the content of token_file, or
    SIGHTLINE_TOKEN, goes with every call. timeout: seconds for each call; None: one minute for calls that send neither
    rays nor meshes, no limit for others. use_segments: whether rays and answers of large casts go through memory that
    this client and a server on the same machine share, where it offers that; Client.transport tells.

    The first call makes the connection, and a later one reconnects if it broke. Errors: ValueError, an endpoint of
    another form or a bad token; OSError, a file that cannot be read; Unauthenticated, a token that would be sent to
    another machine without encryption.
    """
    if endpoint is None:
        endpoint = os.environ.get("SIGHTLINE_ENDPOINT") or DEFAULT_ENDPOINT
    return Client(Connection(endpoint, tls_ca, tls_cert, tls_key, token, token_file, timeout, use_segments))


def resource_name(name: str, project: str = "default") -> str:
    """projects/{project}/scenes/{name}; a full name stays."""
    return name if "/" in name else f"projects/{project}/scenes/{name}"


def _name_or_all(scene: Optional[str]) -> str:
    return "" if scene is None else resource_name(scene)


def _new_scene(name: str, up_axis: Optional[str], meters_per_unit: float) -> Any:
    """A message Scene for one to be made."""
    if up_axis not in _UP:
        raise ValueError(f"up_axis is 'y' or 'z', not {up_axis!r}")
    return _proto.Scene(name=resource_name(name), up_axis=_UP[up_axis], meters_per_unit=meters_per_unit)


class Client:
    """Threads: any. Every call may raise an error of sightline.errors: Unavailable where the server cannot be reached,
    after retries for calls that may be repeated."""

    def __init__(self, connection: Connection):
        self._connection = connection
        self._session = Session(connection)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<sightline client of {self.endpoint}>"

    @property
    def endpoint(self) -> str:
        """Where the server listens."""
        return self._connection.endpoint

    def close(self) -> None:
        """Ends the connection and all calls."""
        self._connection.close()

    def server_info(self) -> ServerInfo:
        """What the server says of itself: version, features, limits, memory."""
        return ServerInfo.of(self._connection.call("GetServerInfo", _proto.GetServerInfoRequest()))

    def read_log(self, after: int = 0) -> LogLines:
        """The end of the server's log, which it keeps in memory; after: the number of a line, for only later ones.
        Errors: PermissionDenied, unless the token is of an administrator of all scenes."""
        answer = self._connection.call("ReadLog", _proto.ReadLogRequest(after=after))
        return LogLines(answer.first, tuple(answer.lines))

    @property
    def transport(self) -> Transport:
        """How large casts go to the server, as far as is known: that is found by the first cast of 8,192 rays or more,
        or by share_memory(). Answers are the same either way: what does not work through shared memory is sent in
        messages, and tried again later."""
        return self._connection.segments.transport()

    def share_memory(self, size: int) -> SharedMemory:
        """Memory of at least `size` bytes for the columns of casts, which are then not copied; see SharedMemory. Where
        the server offers none it is ordinary memory, and says so. The server counts it as memory that it holds, until
        the last array and the SharedMemory are gone. Errors: ValueError, size is not above 0; ResourceExhausted, there
        is not as much memory."""
        if size <= 0:
            raise ValueError(f"size is above 0, not {size}")
        return SharedMemory(self._connection.segments.share(size))

    def max_rays_per_request(self) -> int:
        """A limit of the server, which is asked once."""
        return self._session.max_rays_per_request()

    def scene(self, name: str) -> Scene:
        """A scene by its id in project "default", or its full name. Makes no call: an unknown scene is NotFound when
        it is first used."""
        return Scene(self._session, resource_name(name))

    def create_scene(self, name: str, *, up_axis: Optional[str] = None, meters_per_unit: float = 0) -> Scene:
        """A new, empty scene. up_axis "y" or "z" and meters_per_unit are recorded. Errors: AlreadyExists."""
        scene = _new_scene(name, up_axis, meters_per_unit)
        self._connection.call("CreateScene", _proto.CreateSceneRequest(scene=scene), scene=scene.name)
        self._session.begin_scene(scene.name)
        return Scene(self._session, scene.name)

    def delete_scene(self, name: str) -> None:
        """Errors: NotFound."""
        self._session.delete_scene(resource_name(name))

    def scenes(self, project: str = "default") -> List[SceneInfo]:
        """The scenes of a project, by name."""
        return list(self._pages(project))

    list_scenes = scenes

    def _pages(self, project: str) -> "Iterator[SceneInfo]":
        token = ""
        while True:
            page = self._connection.call("ListScenes", _proto.ListScenesRequest(
                parent=f"projects/{project}", page_token=token))
            yield from map(SceneInfo.of, page.scenes)
            token = page.next_page_token
            if not token:
                return

    def import_arrays(self, name: str, vertices: Any, faces: Any, *, origin: Any = (0.0, 0.0, 0.0),
                      replace: bool = False, up_axis: Optional[str] = None, meters_per_unit: float = 0,
                      mobility: Optional[str] = None, progress: Progress = False) -> Scene:
        """A scene of one mesh. vertices: real (v, 3), kept as float32, about a point near them if `origin` (3) is one,
        as Scene.add does; faces: integers (f, 3).

        Either the whole scene is made or none. `replace`: in the place of one of this name, in one step where the
        server has PutScene; else the old scene is deleted before. progress: of the bytes of the mesh. Errors:
        ValueError, TypeError (not a mesh), AlreadyExists, ResourceExhausted (too large).
        """
        made = _new_scene(name, up_axis, meters_per_unit)
        lattice = Lattice()
        mesh = as_mesh((vertices, faces), lattice if np.any(origin) else None)
        if not replace and self._exists(made.name):
            raise errors.AlreadyExists(f"scene {made.name} exists", "SCENE_EXISTS")
        digest = upload(self._connection, mesh, progress=progress)
        nodes = [put_node(-1, 0, "mesh", None, digest if mesh.placement is None else "", mobility, None)]
        if mesh.placement is not None:
            nodes.append(put_node(-2, -1, "mesh", translation(mesh.placement.origin), digest, mobility, None))
        if not self._put_scene(made, [updates.encode(node).put_node for node in nodes], replace):
            self._import_in_steps(made, nodes, replace)
        self._session.begin_scene(made.name, lattice)
        return Scene(self._session, made.name)

    def import_file(self, name: str, path: Path, *, replace: bool = False, allow_empty: bool = False,
                    up_axis: Optional[str] = None, meters_per_unit: Optional[float] = None, mobility: Optional[str] = None,
                    timeout: Optional[float] = None, program: Optional[str] = None) -> Scene:
        """A scene of a file: glTF 2.0 (.gltf, .glb), OBJ, PLY, STL, Collada (.dae), IFC2X3 (.ifc), AC3D (.ac) or FBX.

        The command `sightline` imports it: a process of it reads the file, which sees no file outside the file's folder
        and no network, and has limits on memory and time, so that the file may come from a stranger. Everything is read
        before anything is sent, and the scene appears in one step. `replace`: in the place of one of this name.
        allow_empty: also if no ray can hit anything. up_axis, meters_per_unit: where the file says otherwise the scene
        is turned or scaled to them. mobility: of all nodes. timeout: seconds for each call. program: the path of
        sightline; default: SIGHTLINE, else the wheel's own, else the one in PATH. Errors: FileNotFoundError, there is no
        such program or file; InvalidArgument, the file cannot be read; ValueError, a word that the command does not
        know; AlreadyExists, ResourceExhausted. Warnings: FileWarning, what was left out or changed.
        """
        made = _new_scene(name, up_axis, meters_per_unit or 0)
        if mobility is not None:
            updates.check_mobility(mobility)
        scene = str(made.name)
        _import_file.import_file(self._connection, find_program("sightline", program, "SIGHTLINE"), scene, path,
                                 replace=replace, allow_empty=allow_empty, up_axis=up_axis, meters_per_unit=meters_per_unit,
                                 mobility=mobility, timeout=timeout)
        self._session.begin_scene(scene)
        return Scene(self._session, scene)

    def backup(self, directory: Path, scene: Optional[str] = None, *, timeout: Optional[float] = None,
               progress: Progress = False) -> "List[BackupScene]":
        """Copies the server's scenes, or one, to a directory of this machine that is empty or missing, each as it is
        when its turn comes; writers go on. The command restores it, too. progress: of bytes. Errors:
        FailedPrecondition, the directory is not empty (BACKUP_NOT_EMPTY), or the server keeps scenes in memory only;
        NotFound; OSError."""
        return _backup.backup(self._connection, directory, _name_or_all(scene), timeout, progress)

    def restore(self, directory: Path, scene: Optional[str] = None, *, revision: Optional[int] = None,
                timeout: Optional[float] = None, progress: Progress = False) -> "List[RestoredScene]":
        """Puts the scenes of a backup, or one, in the place of those with the same names, or makes them. revision: that
        of each restored scene; default: the newest. After an error some may be restored. Errors: DataLoss, the backup
        is not whole; OutOfRange, it does not have the revision; NotFound, nor the scene; FailedPrecondition, the server
        keeps scenes in memory only; OSError."""
        restored = _backup.restore(self._connection, directory, _name_or_all(scene), revision, timeout, progress)
        for one in restored:
            self._session.begin_scene(one.name)
        return restored

    def _put_scene(self, scene: Any, nodes: "List[Any]", replace: bool) -> bool:
        """Makes the scene in one step. False: the server does not have the call."""
        if "PutScene" not in _proto.methods:
            return False
        request = _proto.PutSceneRequest(scene=scene, replace=replace, nodes=nodes, finish=True)
        try:
            self._connection.call("PutScene", [request], scene=scene.name)
        except errors.Unimplemented:
            return False
        return True

    def _import_in_steps(self, scene: Any, nodes: "List[updates.PutNode]", replace: bool) -> None:
        if replace and self._exists(scene.name):
            self.delete_scene(scene.name)
        self._connection.call("CreateScene", _proto.CreateSceneRequest(scene=scene), scene=scene.name)
        try:
            apply(self._connection, scene.name, nodes)
        except BaseException:
            self.delete_scene(scene.name)
            raise

    def _exists(self, name: str) -> bool:
        try:
            self.scene(name).info()
        except errors.NotFound:
            return False
        return True
