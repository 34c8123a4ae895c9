// Elements in a line of code.

/** make('button', { id: 'x', onclick }, 'text', child) */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === 'class') element.className = value;
    else if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

export const group = (title, ...children) => make('div', { class: 'group' }, make('h3', {}, title), ...children);
export const row = (...children) => make('div', { class: 'row' }, ...children);
export const button = (text, onclick, properties = {}) => make('button', { type: 'button', onclick, ...properties }, text);

/** Fills a select with [value, text] pairs and keeps what was chosen, or else chooses `wanted`. */
export function fill(select, pairs, wanted) {
  const chosen = pairs.some(([value]) => value === select.value) && wanted === undefined ? select.value : wanted;
  select.replaceChildren(...pairs.map(([value, text]) => make('option', { value }, text)));
  if (chosen !== undefined) select.value = chosen;
}
