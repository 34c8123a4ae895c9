"""A gate with keys before a PLAIN server, for tests: it shakes hands as section 12 of PROTOCOL.md says, and hands the Packets of DATA
datagrams on as PLAIN ones under the same session number and counter, and back."""
import hashlib
import os
import socket
import threading

from hapticd import noise, wire


class KeyedGate:
    """`keys`: number of a role in a HELLO to psk; `own`: private half of its own key. Counts what it sees, so that tests can look."""

    def __init__(self, server_address, keys, own):
        self.server_address, self.keys, self.own = server_address, keys, own
        self.secret = os.urandom(16)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.0005)
        self.address = self.socket.getsockname()
        self.sessions = {}  # number: [source, receive, send, socket to the server]
        self.welcomes = {}  # public key of the client: WELCOME
        self.hellos, self.retries, self.answered_bytes, self.hello_bytes = 0, 0, 0, 0
        self.stopping = False
        self.thread = threading.Thread(target=self.loop, daemon=True)
        self.thread.start()

    def stop(self):
        self.stopping = True
        self.thread.join()
        self.socket.close()
        for _, _, _, inner in self.sessions.values():
            inner.close()

    def loop(self):
        while not self.stopping:
            try:
                data, source = self.socket.recvfrom(2048)
                self.from_client(data, source)
            except socket.timeout:
                pass
            for number, (source, _, send, inner) in self.sessions.items():
                self.from_server(number, source, send, inner)

    def from_client(self, data, source):
        hello = wire.decode(data, wire.KIND_HELLO)
        if hello is not None and len(data) == 1200 and hello.session == 0:
            self.hellos += 1
            self.hello_bytes += len(data)
            self.take_hello(hello.body, source)
        datagram = wire.decode(data, wire.KIND_DATA)
        if datagram is not None and datagram.session in self.sessions:
            _, receive, _, inner = self.sessions[datagram.session]
            body = receive.open(datagram.counter, data[:16], datagram.body)
            if body is not None:
                inner.send(wire.encode(wire.KIND_PLAIN, datagram.session, datagram.counter, body))

    def take_hello(self, body, source):
        role, length = body[0], body[1]
        at = 2 + length
        cookie, key_id, message, tag = body[2:at], body[at:at + 8], body[at + 8:at + 56], body[at + 56:at + 72]
        if role not in self.keys or length > 64 or key_id != noise.key_id(self.keys[role]):
            return
        if tag != noise.hello_tag(self.keys[role], wire.encode(wire.KIND_HELLO, 0, 0, body[:at + 56])):
            return
        handshake = noise.Handshake(False, self.keys[role], b"hapticd\x01" + bytes([role]), self.own)
        if handshake.read(message) != b"":
            return
        right = hashlib.blake2b(repr(source).encode() + message[:32], key=self.secret, digest_size=16).digest()
        if cookie != right:
            self.retries += 1
            self.answer(wire.encode(wire.KIND_RETRY, 0, 0, right), source)
            return
        if message[:32] not in self.welcomes:
            number = 1000 + len(self.sessions)
            self.welcomes[message[:32]] = wire.encode(wire.KIND_WELCOME, number, 0, handshake.write(message[:32]))
            inner = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            inner.setblocking(False)
            inner.connect(self.server_address)
            send, receive = handshake.split()
            self.sessions[number] = (source, receive, send, inner)
        self.answer(self.welcomes[message[:32]], source)

    def answer(self, data, source):
        self.answered_bytes += len(data)
        self.socket.sendto(data, source)

    def from_server(self, number, source, send, inner):
        try:
            while True:
                datagram = wire.decode(inner.recv(2048))
                header = wire.encode(wire.KIND_DATA, number, datagram.counter, b"")
                if len(datagram.body) <= 1168:
                    self.socket.sendto(header + send.seal(datagram.counter, header, datagram.body), source)
        except OSError:
            pass
