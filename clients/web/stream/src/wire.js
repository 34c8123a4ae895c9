// The messages of the stream. 64-bit integers come as plain numbers: instants are ns since the machine started, exact up to 104 days
// of it and to 2 ns beyond, and nothing drawn is that fine.
import protobuf from 'protobufjs/minimal.js';

protobuf.util.Long = undefined;
protobuf.configure();
const { hapticd } = await import('./generated/wire.js');

export const v1 = hapticd.v1;

/** Name of an enum value without the prefix that protobuf wants: nameOf(v1.Cause, 'CAUSE_', 9) is 'device lost'. */
export function nameOf(values, prefix, value) {
  const found = Object.keys(values).find((name) => values[name] === value);
  if (!found || value === 0) return '';
  return found.slice(prefix.length).toLowerCase().replaceAll('_', ' ');
}

/** Lower-case hexadecimal, as /asset/HASH wants it. */
export function hex(bytes) {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
}
