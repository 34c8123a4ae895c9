// Stands where hapticd is expected and speaks another wire major: every datagram comes back with 2 in place of 1, the bytes of a header of
// the future behind it. usage: node other_major.js HOST PORT
import { createSocket } from 'node:dgram';

const [host, port] = process.argv.slice(2);
const socket = createSocket('udp4');
socket.on('message', (datagram, from) => {
  const answer = Buffer.from(datagram);
  answer[1] = 2;
  socket.send(answer, from.port, from.address);
});
socket.bind(Number(port), host, () => console.log('listening on', host, port));
