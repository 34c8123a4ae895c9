// The Markdown of a summary as elements: headings, tables, lists and paragraphs, as hapticd-lab writes them. Text stays text.
import { make } from './dom.js';

/** [{kind: 'heading'|'table'|'list'|'text', ...}] of the lines: `text`, `rows` of cells, or `items`. */
export function summaryBlocks(text) {
  const blocks = [];
  const into = (kind, name, value) => {
    if (blocks.at(-1)?.kind !== kind) blocks.push({ kind, [name]: [] });
    blocks.at(-1)[name].push(value);
  };
  for (const line of text.split('\n')) {
    if (/^\|[-|: ]+\|$/.test(line)) continue; // the rule below a table's heading
    if (line.startsWith('|')) into('table', 'rows', line.slice(1, -1).split('|').map((cell) => cell.trim()));
    else if (line.startsWith('- ')) into('list', 'items', line.slice(2));
    else if (line.startsWith('#')) blocks.push({ kind: 'heading', text: line.replace(/^#+ */, '') });
    else if (line.trim()) blocks.push({ kind: 'text', text: line });
  }
  return blocks;
}

const MAKERS = {
  heading: ({ text }) => make('h3', {}, text),
  text: ({ text }) => make('p', { class: 'note' }, text),
  list: ({ items }) => make('ul', {}, ...items.map((item) => make('li', {}, item))),
  table: ({ rows }) => make('table', {}, ...rows.map((cells, i) => make('tr', {}, ...cells.map((cell) => make(i === 0 ? 'th' : 'td', {}, cell))))),
};

export const summaryElements = (text) => summaryBlocks(text).map((block) => MAKERS[block.kind](block));
