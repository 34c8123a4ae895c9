// Types of the generated messages, as their decoders give them: numbers instead of 64-bit integers, null for a message or a member of a oneof
// that is absent, [] for nothing repeated. pbts would describe what may be encoded, with Long, and needs comments in the code.
import protobuf from 'protobufjs';

const HEAD = `// Made by make_wire.js from proto/hapticd/v1.
/** What may be encoded as a message: any of its fields, as plain objects. */
export type Plain<T> = T extends Uint8Array ? T : T extends (infer E)[] ? readonly Plain<E>[] : T extends object ? { [K in keyof T]?: Plain<T[K]> } : T;
export interface Codec<T> {
  encode(message: Plain<T>): { finish(): Uint8Array };
  decode(bytes: Uint8Array): T;
}
`;

const comment = (text, indent = '') => (text ? `${indent}/** ${text.replaceAll('*/', '* /').replaceAll('\n', ' ')} */\n` : '');

/** The file of types of a namespace of the schema. */
export function typesOf(namespace) {
  return HEAD + namespace.nestedArray.map((each) => (each instanceof protobuf.Enum ? enumText(each) : messageText(each))).join('');
}

function enumText(each) {
  const values = Object.entries(each.values).map(([name, value]) => `${comment(each.comments[name], '  ')}  ${name} = ${value},\n`).join('');
  return `${comment(each.comment)}export enum ${each.name} {\n${values}}\n`;
}

function messageText(type) {
  const fields = type.fieldsArray.map((field) => `${comment(field.comment, '  ')}  ${field.name}: ${fieldType(field)};\n`).join('');
  return `${comment(type.comment)}export interface ${type.name} {\n${fields}}\nexport const ${type.name}: Codec<${type.name}>;\n`;
}

function fieldType(field) {
  const one = scalarType(field);
  if (field.repeated) return `${one}[]`;
  return field.partOf || field.resolvedType instanceof protobuf.Type ? `${one} | null` : one;
}

function scalarType(field) {
  if (field.resolvedType) return field.resolvedType.name;
  if (field.type === 'bool') return 'boolean';
  if (field.type === 'string') return 'string';
  return field.type === 'bytes' ? 'Uint8Array' : 'number';
}
