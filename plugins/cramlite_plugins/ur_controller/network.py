"""Network ports of the virtual controller, on loopback only, and its clock."""

from __future__ import annotations

import asyncio
import ipaddress
import struct
import time
from collections.abc import Awaitable, Callable

from msgspec import Struct, field

from cramlite.plugin import UserError

from .dashboard import GREETING, answer
from .rtde import HEADER, LARGEST, Recipe, packet, recipe
from .sockets import Sockets
from .virtual_robot import VirtualRobot

RTDE, DASHBOARD, SCRIPTS, GRIPPER = 30004, 29999, (30001, 30002, 30003), 63352
CLIENTS = 32  # connections at one time
LINE = 1024  # bytes of a line on the dashboard and the gripper's server
PROGRAM = 5_000_000  # bytes of a program
VERSION = struct.pack(">4I", 5, 12, 0, 1101319)
Reader = asyncio.StreamReader
Writer = asyncio.StreamWriter


class Client(Struct, eq=False):
    """An RTDE connection."""

    writer: Writer
    output: Recipe | None = None
    every: int = 1
    inputs: dict[int, Recipe] = field(default_factory=dict)
    sending: bool = False


class Ports(Struct):
    """Network ports of the virtual robot, and the clients that are connected to them."""

    robot: VirtualRobot
    clients: set[Client] = field(default_factory=set)
    connections: int = 0
    writers: set[Writer] = field(default_factory=set)
    last: float = field(default_factory=time.monotonic)


def serve(
    robot: VirtualRobot,
    host: str,
    *,
    seconds: float,
    idle: float,
    ready: Callable[[str], None],
    each: Callable[[], str] = lambda: "",
) -> str:
    """Serve the robot until time is up or nobody has been connected for a while.

    Args:
        host: a loopback address.
        seconds: how long at most; 0 for no limit.
        idle: how long without any connection [s]; 0 for no limit.
        ready: called with a line for people when all ports are open.
        each: called after every control cycle; why the controller should be closed, or "".

    Returns:
        Why it ended.

    Raises:
        UserError: the host is not loopback, or a port is taken.
    """
    try:
        local = ipaddress.ip_address("127.0.0.1" if host == "localhost" else host).is_loopback
    except ValueError:
        local = False
    if not local:
        raise UserError(
            f"The virtual controller serves loopback addresses only (127.0.0.1 to 127.255.255.254), not '{host}'."
        )
    return asyncio.run(_serve(Ports(robot), host, (seconds, idle), ready, each))


async def _serve(
    ports: Ports, host: str, ends: tuple[float, float], ready: Callable[[str], None], each: Callable[[], str]
) -> str:
    handlers = {RTDE: _rtde, DASHBOARD: _dashboard, GRIPPER: _gripper, **dict.fromkeys(SCRIPTS, _script)}
    servers = []
    try:
        for port, handler in handlers.items():
            servers.append(await asyncio.start_server(_guarded(ports, handler), host, port))
    except OSError as error:
        raise UserError(
            f"Port {port} of {host} cannot be opened: {error.strerror}. Choose another --host, e.g. 127.0.0.2."
        ) from error
    else:
        ready(
            f"Ready on {host}: RTDE {RTDE}, dashboard {DASHBOARD}, scripts {SCRIPTS[0]} to {SCRIPTS[-1]}, gripper {GRIPPER}"
        )
        return await _clock(ports, *ends, each)
    finally:
        for server in servers:
            server.close()


async def _clock(ports: Ports, seconds: float, idle: float, each: Callable[[], str]) -> str:
    """Run control cycles in real time if the machine is fast enough; else simulated time falls behind, and no
    cycle is skipped."""
    begin = due = time.monotonic()
    count = 0
    while True:
        ports.robot.cycle()
        count += 1
        _publish(ports, count)
        if not ports.robot.reachable:
            _send_away(ports)
        if why := each():
            return why
        due += ports.robot.arm.period
        now = time.monotonic()
        due = max(due, now - 0.1)
        await asyncio.sleep(max(0.0, due - now))
        if seconds and now - begin > seconds:
            return f"{seconds:g} s are over"
        if ports.connections:
            ports.last = now
        elif idle and now - ports.last > idle:
            return f"nobody was connected for {idle:g} s"


def _send_away(ports: Ports) -> None:
    """Break every connection, as a cable that is pulled does."""
    for writer in list(ports.writers):
        writer.transport.abort()


def _publish(ports: Ports, count: int) -> None:
    for client in list(ports.clients):
        if client.sending and client.output is not None and count % client.every == 0:
            values = {name: ports.robot.field(name) for name in client.output.names}
            client.writer.write(packet("U", client.output.pack(values)))
            if client.writer.transport.get_write_buffer_size() > 1_000_000:  # a client that does not read
                client.writer.close()
                ports.clients.discard(client)


def _guarded(
    ports: Ports, handler: Callable[[Ports, Reader, Writer], Awaitable[None]]
) -> Callable[[Reader, Writer], Awaitable[None]]:
    """Wrap the handler of a connection, so that an error, or garbage from the client, ends this connection only."""

    async def handle(reader: Reader, writer: Writer) -> None:
        if ports.connections >= CLIENTS or not ports.robot.reachable:
            writer.close()
            return
        ports.connections += 1
        ports.writers.add(writer)
        try:
            await handler(ports, reader, writer)
        except (OSError, EOFError, ValueError, LookupError, struct.error, asyncio.LimitOverrunError) as error:
            if not isinstance(error, asyncio.IncompleteReadError | ConnectionError):
                ports.robot.log(f"a client was disconnected after an error: {type(error).__name__}: {str(error)[:100]}")
        finally:
            ports.connections -= 1
            ports.writers.discard(writer)
            writer.close()

    return handle


async def _rtde(ports: Ports, reader: Reader, writer: Writer) -> None:
    client = Client(writer)
    ports.clients.add(client)
    try:
        while True:
            size, kind = HEADER.unpack(await reader.readexactly(HEADER.size))
            if not HEADER.size <= size <= LARGEST:
                raise ValueError(f"an RTDE packet cannot have {size} bytes")
            content = await reader.readexactly(size - HEADER.size)
            if reply := _answer_rtde(ports.robot, client, chr(kind), content):
                writer.write(packet(chr(kind), reply))
                await writer.drain()
    finally:
        ports.clients.discard(client)


def _answer_rtde(robot: VirtualRobot, client: Client, kind: str, content: bytes) -> bytes:
    match kind:
        case "V":
            return bytes([content == b"\x00\x02"])
        case "v":
            return VERSION
        case "O":
            (frequency,) = struct.unpack(">d", content[:8])
            if not 0 < frequency <= 500:
                raise ValueError(f"outputs were asked for at {frequency:g} Hz, and at most 500 Hz is possible")
            client.output = recipe(1, content[8:].decode(), output=True)
            client.every = max(1, round(1 / robot.arm.period / frequency))
            return _described(client.output)
        case "I":
            if len(client.inputs) >= 255:
                raise ValueError("a client asked for more than 255 input recipes")
            found = recipe(len(client.inputs) + 1, content.decode(), output=False)
            client.inputs[found.number] = found
            return _described(found)
        case "S":
            client.sending = client.output is not None and client.output.complete
            return bytes([client.sending])
        case "P":
            client.sending = False
            return b"\x01"
        case "U":
            robot.registers.write_inputs(client.inputs[content[0]].unpack(content))
            return b""
    raise ValueError(f"RTDE packets of type {kind!r} are not modelled here")


def _described(found: Recipe) -> bytes:
    return bytes([found.number if found.complete else 0]) + ",".join(found.types).encode()


async def _dashboard(ports: Ports, reader: Reader, writer: Writer) -> None:
    writer.write(f"{GREETING}\n".encode())
    while line := await _line(reader):
        said = answer(line.decode("ascii", "replace"), ports.robot)
        writer.write(f"{said}\n".encode())
        await writer.drain()
        if said == "Disconnected":
            return


async def _script(ports: Ports, reader: Reader, writer: Writer) -> None:
    """Read programs from a connection: each ends with ``end`` in column 0; a line outside of def and sec is a
    program of its own."""
    waiting: list[bytes] = []
    size = 0
    while line := await reader.readline():
        size += len(line)
        if size > PROGRAM:
            raise ValueError(f"a client's program has more than {PROGRAM} bytes")
        if not waiting and not line.strip():
            continue
        waiting.append(line)
        alone = len(waiting) == 1 and not line.startswith((b"def", b"sec"))
        if alone or line.rstrip() == b"end":
            ports.robot.receive(b"".join(waiting).decode("utf-8", "replace"))
            waiting, size = [], 0


async def _gripper(ports: Ports, reader: Reader, writer: Writer) -> None:
    sockets = Sockets(ports.robot.arm.gripper_server)
    while line := await _line(reader):
        writer.write(sockets.answer(line.decode("ascii", "replace").split()))
        await writer.drain()


async def _line(reader: Reader) -> bytes:
    line = await reader.readline()
    if len(line) > LINE:
        raise ValueError(f"a line has {len(line)} bytes, and at most {LINE} are read")
    return line
