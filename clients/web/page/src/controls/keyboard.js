// Keys for everything a player wants without a mouse. Not while typing. ? lists them. Escape is Stop's own, controls/stop.js.

export const KEYS = [
  ['1', 'player’s view'], ['2', 'from above'], ['3', 'at the strings'], ['F', 'follow the tool'], ['C', 'contacts'], ['V', 'forces'],
  ['D', 'depth cue'], ['N', 'names'], ['M', 'magnify strings'], ['S', 'stereo'], ['P', 'side'], ['Space', 'pause a recording'],
  ['Escape', 'STOP: zero force'], ['?', 'this list'],
];

/** `actions`: {key: function}; letters in lower case. */
export function listen(actions, target = window) {
  target.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const typing = /^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(event.target.tagName ?? '');
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    // Arrows, space and letters belong to the field or button that has the focus.
    if (typing && (event.target.tagName !== 'BUTTON' || key === ' ')) return;
    const action = actions[key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
