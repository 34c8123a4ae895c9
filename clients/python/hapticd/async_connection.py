"""A conversation in an event loop of asyncio, without a thread: the loop's timers send what is due, and what arrives wakes those who wait.
Not safe for use from other threads."""
from __future__ import annotations

import asyncio
import socket
import time
from typing import Any, Callable, Optional

from hapticd.conversation import MOST_WAITING, RECEIVE_BUFFER_BYTES, Conversation, Peer, host_and_port
from hapticd.link import BYE_PATIENCE_NS
from hapticd.v1 import answer_pb2, stream_pb2


class AsyncConnection(Conversation, asyncio.DatagramProtocol):
    """To be made in the loop that it is used in; `open` begins."""

    def __init__(self, peer: Peer) -> None:
        super().__init__(peer)
        self._loop = asyncio.get_running_loop()
        self._changed: "asyncio.Future[None]" = self._loop.create_future()
        self._transport: Optional[asyncio.DatagramTransport] = None
        self._timer: Optional[asyncio.TimerHandle] = None
        self._end_ns: Optional[int] = None  # after which nothing is left to say

    # For whoever asks.

    async def open(self) -> None:
        """Begins to talk. OSError where the address has no machine."""
        transport, _ = await self._loop.create_datagram_endpoint(lambda: self, remote_addr=host_and_port(self._peer.address))
        self._transport = transport
        found = self._transport.get_extra_info("socket")
        found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        self._pump()

    async def submit(self, item: stream_pb2.Item, awaited: bool = False, at_once: bool = False) -> int:
        """Sends an Item; returns its id. `awaited`: its Result will be fetched. Waits while too many wait, unless `at_once`."""
        self._check_loop()
        self.check()
        if not at_once:
            await self.wait(lambda: self.link.backlog < MOST_WAITING)
        item_id = self.put(item, awaited)
        self._pump()
        return item_id

    async def wait(self, until: Callable[[], Any], timeout_s: Optional[float] = None, survives: bool = False) -> Any:
        """Waits until the condition holds, and returns its value, which is false on timeout. Raises as `check_waiting`. The timer looks
        again every 50 ms at the latest."""
        self._check_loop()
        epoch = self.epoch
        deadline = None if timeout_s is None else self._loop.time() + timeout_s
        while not (found := until()):
            self.check_waiting(epoch, survives)
            left = None if deadline is None else deadline - self._loop.time()
            if left is not None and left <= 0:
                return found
            await asyncio.wait([self._changed], timeout=left)
        return found

    async def result(self, item_id: int) -> answer_pb2.Result:
        """Waits for the Result of an awaited request."""
        try:
            await self.wait(lambda: item_id in self.results)
            return self.results[item_id]
        finally:
            self.forget_request(item_id)

    async def close(self) -> None:
        """Bye, repeated until acknowledged, 1 s at most."""
        self._check_loop()
        if self._transport is None or self._transport.is_closing():
            return
        self.say_bye()
        self._wake()
        try:
            self._pump()
            deadline = self._loop.time() + BYE_PATIENCE_NS * 1e-9
            while not self.link.finished and self._loop.time() < deadline:
                await asyncio.wait([self._changed], timeout=deadline - self._loop.time())
        finally:
            self._end()

    def _check_loop(self) -> None:
        if asyncio.get_running_loop() is not self._loop:
            raise RuntimeError("this session belongs to another event loop: open one in each")

    # For the loop.

    def datagram_received(self, data: bytes, addr: Any) -> None:
        self._guarded(lambda: self.take(data, time.monotonic_ns()))

    def error_received(self, exc: Exception) -> None:
        """Nobody listens, or the buffer is full: a lost datagram like any other."""

    def connection_lost(self, exc: Optional[Exception]) -> None:
        self._end()

    def _guarded(self, action: Callable[[], Any]) -> None:
        """What goes wrong in the loop's callbacks ends the session, and whoever waits hears of it."""
        try:
            action()
            self._pump()
        except Exception as error:
            self.over = self.over or error
            self._end()
        self._wake()

    def _pump(self) -> None:
        """Sends what is due, and comes back when something else is."""
        if self._transport is None or self._transport.is_closing():
            return
        self.watch_silence()
        now_ns = time.monotonic_ns()
        if self._end_ns is None and self.ending:
            self._end_ns = now_ns + BYE_PATIENCE_NS
        if self._end_ns is not None and now_ns > self._end_ns:
            self._end()
            return
        for data in self.due_datagrams():
            self._transport.sendto(data)
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._loop.call_later(max(0.0, (self.link.due_ns() - time.monotonic_ns()) * 1e-9), self._guarded, lambda: None)

    def _wake(self) -> None:
        if not self._changed.done():
            self._changed.set_result(None)
        self._changed = self._loop.create_future()

    def _end(self) -> None:
        """Nothing is sent or received any more."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._transport is not None and not self._transport.is_closing():
            self._transport.close()
