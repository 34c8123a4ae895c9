// Writes a message as protobuf text format, as far as scenes need it: so a scene that arrived can be changed and sent back as LoadScene's
// text. Enum values are written as numbers, which the format allows.

export function textOf(message, indent = '') {
  return Object.keys(message).filter((name) => message[name] !== null && message[name] !== undefined)
    .map((name) => [].concat(asList(message[name])).map((value) => fieldText(name, value, indent)).join('')).join('');
}

function asList(value) {
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}

function fieldText(name, value, indent) {
  if (typeof value === 'object') return `${indent}${name} {\n${textOf(value, `${indent}  `)}${indent}}\n`;
  return `${indent}${name}: ${typeof value === 'string' ? quoted(value) : String(value)}\n`;
}

function quoted(text) {
  const escaped = text.replaceAll('\\', '\\\\').replaceAll('"', '\\"').replaceAll('\n', '\\n');
  return `"${escaped}"`;
}
