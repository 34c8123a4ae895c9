// Makes the package for npm: the modules bundled with what they need, so that it is installed anywhere without a registry, their types, and
// the version of the project, which only its CMakeLists.txt says. Writes FOLDER/hapticd-stream and FOLDER/hapticd-stream-VERSION.tgz.
// usage: node make_package.js [FOLDER [VERSION]]      default: the folder package, and the version of this repository
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2] ?? join(here, 'package'));
const version = process.argv[3] ?? readFileSync(join(here, '../../../CMakeLists.txt'), 'utf8').match(/^project\(hapticd VERSION (\S+)/m)[1];
const made = join(folder, 'hapticd-stream');

rmSync(made, { recursive: true, force: true });
mkdirSync(join(made, 'src/generated'), { recursive: true });
const options = { bundle: true, format: 'esm', target: 'es2022', logLevel: 'warning', metafile: true, absWorkingDir: here };
const shared = await build({ ...options, entryPoints: ['index', 'vector'].map((name) => join(here, `src/${name}.js`)), outdir: join(made, 'src'), platform: 'neutral', mainFields: ['main'] });
// ws is CommonJS and requires what Node has.
const requires = "import { createRequire } from 'node:module'; const require = createRequire(import.meta.url);";
const node = await build({ ...options, entryPoints: [join(here, 'src/node.js')], outdir: join(made, 'src'), platform: 'node', target: 'node18', banner: { js: requires } });
for (const types of ['index', 'node', 'vector', 'generated/v1']) copyFileSync(join(here, `src/${types}.d.ts`), join(made, `src/${types}.d.ts`));
for (const file of ['README.md', 'print_tones.js']) copyFileSync(join(here, file), join(made, file));

// The licences of what is bundled go with it.
const inputs = [shared, node].flatMap(({ metafile }) => Object.keys(metafile.inputs));
const bundled = [...new Set(inputs.map((path) => path.match(/^(.*node_modules\/(?:@[^/]+\/)?[^/]+)\//)?.[1]).filter(Boolean))].sort();
const licences = bundled.map((path) => [join(here, path, 'package.json'), join(here, path, 'LICENSE')]).map(([facts, text]) => {
  const { name, version: of, license } = JSON.parse(readFileSync(facts, 'utf8'));
  return `${name} ${of}, ${license}\n\n${existsSync(text) ? readFileSync(text, 'utf8') : ''}`;
});
writeFileSync(join(made, 'LICENSES'), `The modules of hapticd-stream contain these packages.\n\n${licences.join('\n\n')}`);

const { scripts, dependencies, devDependencies, ...manifest } = JSON.parse(readFileSync(join(here, 'package.json'), 'utf8'));
writeFileSync(join(made, 'package.json'), `${JSON.stringify({ ...manifest, version }, null, 2)}\n`);
execFileSync('npm', ['pack', '--silent', '--pack-destination', folder], { cwd: made, stdio: 'inherit' });
