"""A UDP proxy on loopback that loses, doubles and reorders datagrams both ways, with a seed: what netem would do, in user space. Every
client behind it gets a socket of its own towards the server, so that the server can tell them apart."""
import heapq
import random
import selectors
import socket
import threading
import time

LONGEST_WAIT_S = 0.05


class LossyProxy:
    """Context manager; `address` is where clients go. `loss` and `twice` are probabilities, each way and for each datagram; `jitter_s` is
    how much one may be overtaken."""

    def __init__(self, server, loss=0.4, twice=0.2, jitter_s=0.01, seed=1):
        host, port = server.rsplit(":", 1)
        self.server = (host, int(port))
        self.loss, self.twice, self.jitter_s = loss, twice, jitter_s
        self.random = random.Random(seed)
        self.front = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.front.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.front.setblocking(False)
        self.front.bind(("127.0.0.1", 0))
        self.address = "%s:%d" % self.front.getsockname()
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.front, selectors.EVENT_READ, None)
        self.backs = {}  # client: its socket towards the server
        self.under_way = []  # (when, number, socket, data, client or None)
        self.taken = self.lost = self.doubled = self.overtaken = 0
        self.to_server_bytes = self.to_clients_bytes = 0
        self.newest = {}
        self.stopping = False
        self.thread = threading.Thread(target=self._loop, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.stopping = True
        self.thread.join()
        for each in (self.front, *self.backs.values()):
            each.close()

    def _loop(self):
        while not self.stopping:
            wait = LONGEST_WAIT_S if not self.under_way else self.under_way[0][0] - time.monotonic()
            for key, _ in self.selector.select(max(0.0, min(wait, LONGEST_WAIT_S))):
                self._read(key.fileobj, key.data)
            while self.under_way and self.under_way[0][0] <= time.monotonic():
                self._pass(*heapq.heappop(self.under_way)[1:])

    def _read(self, readable, client):
        try:
            while True:
                data, source = readable.recvfrom(2048)
                if client is None:
                    if source not in self.backs:
                        self.backs[source] = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                        self.backs[source].setblocking(False)
                        self.backs[source].connect(self.server)
                        self.selector.register(self.backs[source], selectors.EVENT_READ, source)
                    self._take(self.backs[source], data, None)
                else:
                    self._take(self.front, data, client)
        except (BlockingIOError, ConnectionRefusedError):
            pass  # all read, or nobody listens there just now

    def _take(self, out, data, client):
        if client is None:
            self.to_server_bytes += len(data)
        else:
            self.to_clients_bytes += len(data)
        copies = 2 if self.random.random() < self.twice else 1
        self.doubled += copies - 1
        for _ in range(copies):
            self.taken += 1
            if self.random.random() < self.loss:
                self.lost += 1
            else:
                when = time.monotonic() + self.random.uniform(0.0, self.jitter_s)
                heapq.heappush(self.under_way, (when, self.taken, out, data, client))

    def _pass(self, number, out, data, client):
        self.overtaken += number < self.newest.get((out, client), 0)
        self.newest[(out, client)] = max(number, self.newest.get((out, client), 0))
        try:
            if client is None:
                out.send(data)
            else:
                out.sendto(data, client)
        except OSError:
            pass  # nobody listens: lost like any other
