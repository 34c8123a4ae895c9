// The committed example messages, as the page reads them and as the bytes they are.
import { readFileSync } from 'node:fs';
import { v1 } from '../../../../clients/web/stream/src/wire.js';

const lines = readFileSync(new URL('data/messages.txt', import.meta.url), 'utf8').split('\n').filter((line) => line && !line.startsWith('#'));
const examples = new Map(lines.map((line) => line.split(' ')).map(([type, name, bytes]) => [name, { type, bytes: Uint8Array.from(Buffer.from(bytes, 'hex')) }]));

export const names = [...examples.keys()];
export const bytesOf = (name) => examples.get(name).bytes;
export const typeOf = (name) => v1[examples.get(name).type];
export const exampleOf = (name) => typeOf(name).decode(bytesOf(name));
