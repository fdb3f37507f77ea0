"""URScript's sockets on the virtual controller: the gripper's server and, if there is one, the perception server.

Wrong arguments, and any other address, raise ``ScriptError``.
"""

from __future__ import annotations

import re
from collections.abc import Generator
from typing import Any

from ..simulation.controller.gripper_server import GripperServer
from .pose_server import ADDRESS as PERCEPTION
from .pose_server import PoseServer
from .urscript.values import ScriptError, show

ADDRESS = ("127.0.0.1", 63352)  # Robotiq's URCap
SOCKETS = (
    "socket_open", "socket_close", "socket_set_var", "socket_get_var", "socket_send_string", "socket_send_line",
    "socket_read_byte_list", "socket_read_string", "socket_read_ascii_float",
)  # fmt: skip
LONGEST = 10_000  # bytes of unread answers


class Sockets:
    """The open sockets of a program, by name, with the bytes that wait to be read.

    A question takes one control cycle, as the way to the server and back does.
    """

    def __init__(self, server: GripperServer, poses: PoseServer | None = None) -> None:
        self.server, self.poses = server, poses
        self.open: dict[str, bytearray] = {}
        self.perception: set[str] = set()

    def socket_open(self, address: Any, port: Any, socket_name: Any = "socket_0") -> bool:
        """Open a socket to the gripper's or the perception server."""
        if (address, port) == PERCEPTION and self.poses is not None:
            self.perception.add(show(socket_name))
        elif (address, port) == ADDRESS:
            self.perception.discard(show(socket_name))
        else:
            only = f"only the gripper's server {ADDRESS[0]}:{ADDRESS[1]} may be reached"
            only += f", and the perception server {PERCEPTION[0]}:{PERCEPTION[1]}" if self.poses is not None else ""
            raise ScriptError(f"socket to {show(address)}:{show(port)} refused: {only}")
        self.open[show(socket_name)] = bytearray()
        return True

    def socket_close(self, socket_name: Any = "socket_0") -> None:
        """Close the socket that the program opened under this name."""
        self.open.pop(show(socket_name), None)

    def socket_set_var(self, name: Any, value: Any, socket_name: Any = "socket_0") -> None:
        """Send "SET name value" to the server on a socket."""
        if type(value) is not int:
            raise ScriptError(f"socket_set_var needs an integer, not {show(value)}")
        self._send(f"SET {show(name)} {value}", socket_name)

    def socket_get_var(self, name: Any, socket_name: Any = "socket_0") -> Generator[None, None, int]:
        """Ask the gripper's server for the value of a variable; return it, or 0 for an unknown name."""
        self._buffer(socket_name)
        yield
        value = self.server.ask(show(name))
        return 0 if value is None else value

    def socket_send_string(self, str: Any, socket_name: Any = "socket_0") -> bool:
        """Send a text to the server on a socket, line by line."""
        for line in show(str).splitlines():
            self._send(line, socket_name)
        return True

    def socket_send_line(self, str: Any, socket_name: Any = "socket_0") -> bool:
        """Send a line to the server on a socket."""
        return self.socket_send_string(str, socket_name)

    def socket_read_byte_list(
        self, number: Any, socket_name: Any = "socket_0", timeout: Any = 2
    ) -> Generator[None, None, list[int]]:
        """Read at most ``number`` bytes from a socket; return a list of their count and the bytes."""
        buffer = self._buffer(socket_name)
        yield
        if type(number) is not int or number <= 0:
            raise ScriptError(f"socket_read_byte_list needs a positive count, not {show(number)}")
        taken = bytes(buffer[:number])
        del buffer[:number]
        return [len(taken), *taken]

    def socket_read_string(
        self, socket_name: Any = "socket_0", prefix: Any = "", suffix: Any = "", interpret_escape: Any = False, timeout: Any = 2
    ) -> Generator[None, None, str]:
        """Read all waiting bytes as a string; ``prefix`` and ``suffix``, which would cut out a part, are refused."""
        if prefix != "" or suffix != "":
            raise ScriptError("socket_read_string: prefix and suffix are not modelled here: read all and use str_find and str_sub")
        buffer = self._buffer(socket_name)
        yield
        taken = buffer.decode("ascii", "replace")
        buffer.clear()
        return taken

    def socket_read_ascii_float(
        self, number: Any, socket_name: Any = "socket_0", timeout: Any = 2
    ) -> Generator[None, None, list[float]]:
        """Read floats "(1.0, 2.0)": return ``number`` and the floats; all zeros if another number of floats
        arrived."""
        said = yield from self.socket_read_string(socket_name, timeout=timeout)
        if type(number) is not int or not 0 < number <= 30:
            raise ScriptError(f"socket_read_ascii_float needs a count of 1 to 30, not {show(number)}")
        found = re.findall(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?", said.partition("(")[2].partition(")")[0])
        values = [float(v) for v in found]
        return [len(values), *values] if len(values) == number else [0, *[0.0] * number]

    def _send(self, line: str, socket_name: Any) -> None:
        buffer = self._buffer(socket_name)
        asked = self.poses is not None and show(socket_name) in self.perception
        buffer += self.poses.answer(line) if asked and self.poses else self.answer(line.split())
        if len(buffer) > LONGEST:
            raise ScriptError(f"socket '{show(socket_name)}': more than {LONGEST} bytes wait to be read")

    def answer(self, words: list[str]) -> bytes:
        """Answer a request to the gripper's server, given as words; SET takes one or more pairs of name and value."""
        if words[:1] == ["GET"] and len(words) == 2 and (value := self.server.ask(words[1])) is not None:
            return f"{words[1]} {value}\n".encode()
        pairs = list(zip(words[1::2], words[2::2], strict=False))
        if words[:1] != ["SET"] or not pairs or len(words) % 2 == 0 or not all(v.isdigit() for _, v in pairs):
            return b"?"
        done = [self.server.order(n, int(v)) for n, v in pairs]
        return b"ack" if all(done) else b"?"

    def _buffer(self, socket_name: Any) -> bytearray:
        name = show(socket_name)
        if name not in self.open:
            raise ScriptError(f"socket '{name}' is not open")
        return self.open[name]
