// Writes src/generated: readers and writers of the messages that clients and gateway exchange, from the same .proto files as everyone
// else's, and their types. Static code, because code made at run time would need 'unsafe-eval' in a page's Content-Security-Policy.
// usage: node make_wire.js [FOLDER OF hapticd/v1]      default: proto of this repository
import { execFileSync } from 'node:child_process';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import protobuf from 'protobufjs';
import { typesOf } from './wire_types.js';

const here = dirname(fileURLToPath(import.meta.url));
const protos = process.argv[2] ?? process.env.HAPTICD_PROTO ?? join(here, '../../../proto');
const out = join(here, 'src/generated');

// The rules of requests are for servers, and all of descriptor.proto would come with them.
const root = new protobuf.Root();
root.resolvePath = (origin, target) => (target.endsWith('/request.proto') ? null : join(protos, target));
root.loadSync('hapticd/v1/gateway.proto', { keepCase: true, alternateCommentMode: true });
mkdirSync(out, { recursive: true });
const schema = join(out, 'schema.json');
writeFileSync(schema, JSON.stringify(root));
execFileSync(process.execPath, [
  createRequire(import.meta.url).resolve('protobufjs-cli/bin/pbjs'),
  ...'--target static-module --wrap es6 --keep-case --no-create --no-verify --no-convert --no-delimited --no-typeurl --no-comments'.split(' '),
  '--out', join(out, 'wire.js'), schema,
], { stdio: 'inherit' });
rmSync(schema);
root.resolveAll();
writeFileSync(join(out, 'v1.d.ts'), typesOf(root.lookup('hapticd.v1')));
