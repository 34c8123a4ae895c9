"""The thread that keeps one session alive: it sends what is due, receives, and hands on to the Conversation what came. A daemon thread, so
that lease and keep-alive hold while the user's code computes; everything it shares is guarded by `changed`."""
from __future__ import annotations

import select
import socket
import threading
import time
from typing import Any, Callable, Optional

from hapticd.conversation import MOST_DATAGRAM_BYTES, MOST_WAITING, RECEIVE_BUFFER_BYTES, Conversation, Peer, host_and_port
from hapticd.link import BYE_PATIENCE_NS
from hapticd.v1 import answer_pb2, stream_pb2

_BURST = 256  # datagrams read before something may be sent


def open_socket(address: str) -> socket.socket:
    """A UDP socket connected to "HOST:PORT", "HOST" or "[IPv6]:PORT"."""
    family, kind, protocol, _, target = socket.getaddrinfo(*host_and_port(address), type=socket.SOCK_DGRAM)[0]
    found = socket.socket(family, kind, protocol)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
    found.setblocking(False)
    found.connect(target)
    return found


class Connection(Conversation):
    """A conversation with a socket and a thread of its own."""

    def __init__(self, peer: Peer) -> None:
        self.changed = threading.Condition()
        super().__init__(peer)
        self._socket = open_socket(peer.address)
        self._wake_in, self._wake_out = socket.socketpair()
        self._wake_in.setblocking(False)
        self._thread = threading.Thread(target=self._run, name="hapticd", daemon=True)
        self._thread.start()

    # For the user's thread.

    def submit(self, item: stream_pb2.Item, awaited: bool = False, at_once: bool = False) -> int:
        """Sends an Item; returns its id. `awaited`: its Result will be fetched. Waits while too many wait, unless `at_once`."""
        with self.changed:
            self.check()
            if not at_once:
                self.wait(lambda: self.link.backlog < MOST_WAITING)
            item_id = self.put(item, awaited)
        self._wake()
        return item_id

    def wait(self, until: Callable[[], Any], timeout_s: Optional[float] = None, survives: bool = False) -> Any:
        """Waits, with `changed` held, until the condition holds, and returns its value, which is false on timeout. Raises as
        `check_waiting`."""
        epoch = self.epoch
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while not (found := until()):
            self.check_waiting(epoch, survives)
            left = 0.1 if deadline is None else min(0.1, deadline - time.monotonic())
            if left <= 0:
                return found
            self.changed.wait(left)
        return found

    def result(self, item_id: int) -> answer_pb2.Result:
        """Waits for the Result of an awaited request."""
        with self.changed:
            try:
                self.wait(lambda: item_id in self.results)
                return self.results[item_id]
            finally:
                self.forget_request(item_id)

    def close(self) -> None:
        """Bye, repeated until acknowledged, 1 s at most; then the thread ends."""
        with self.changed:
            self.say_bye()
        self._wake()
        self._thread.join(BYE_PATIENCE_NS * 2e-9)

    def _wake(self) -> None:
        try:
            self._wake_out.send(b"!")
        except OSError:
            pass  # the thread has ended

    # The thread.

    def _run(self) -> None:
        end_ns: Optional[int] = None
        try:
            while end_ns is None or time.monotonic_ns() < end_ns:
                timeout_s = self._send_due()
                readable, _, _ = select.select([self._socket, self._wake_in], [], [], timeout_s)
                with self.changed:
                    if self._wake_in in readable:
                        self._drain_wake()
                    if self._socket in readable:
                        self._receive()
                    self.watch_silence()
                    if end_ns is None and self.ending:
                        end_ns = time.monotonic_ns() + BYE_PATIENCE_NS
                    self.changed.notify_all()
                    if self._stopping and self.link.finished:
                        break
        except Exception as error:  # whoever waits must hear of it
            with self.changed:
                self.over = self.over or error
                self.changed.notify_all()
        for each in (self._socket, self._wake_in, self._wake_out):
            each.close()

    def _send_due(self) -> float:
        """Sends what is due and returns how long nothing else will be, in s."""
        with self.changed:
            for data in self.due_datagrams():
                try:
                    self._socket.send(data)
                except OSError:
                    pass  # nobody listens, or the buffer is full: a lost datagram like any other
            return max(0.0, (self.link.due_ns() - time.monotonic_ns()) * 1e-9)

    def _drain_wake(self) -> None:
        try:
            while self._wake_in.recv(4096):
                pass
        except BlockingIOError:
            pass

    def _receive(self) -> None:
        for _ in range(_BURST):
            try:
                data = self._socket.recv(MOST_DATAGRAM_BYTES)
            except OSError:
                return  # all read, or nobody listens
            if not self.take(data, time.monotonic_ns()):
                return
