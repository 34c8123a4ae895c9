// What must not be missed: a latched fault with its cause and remedy, a broken connection, lost packets. One banner per kind.
import { nameOf, v1 } from 'hapticd-stream';
import { button, make } from './dom.js';

export class Banners {
  #holder;
  #shown = new Map();

  constructor(holder) {
    this.#holder = holder;
  }

  /** Shows, changes or (with null) removes the banner `kind`: {title, text, warn, action: [label, function]}. */
  set(kind, banner) {
    const before = this.#shown.get(kind);
    const key = banner && `${banner.title}|${banner.text}|${banner.action?.[0] ?? ''}`;
    if (before?.key === key) return;
    before?.element.remove();
    this.#shown.delete(kind);
    if (!banner) return;
    const element = make('div', { class: `banner${banner.warn ? ' warn' : ''}`, 'data-kind': kind },
      make('div', {}, make('b', {}, banner.title), banner.text ?? ''));
    if (banner.action) element.append(button(...banner.action));
    this.#holder.append(element);
    this.#shown.set(kind, { key, element });
  }
}

const REMEDIES = {
  overrun: 'Ticks were late too often. hapticctl doctor says what makes them late on this machine.',
  'device lost': 'Plug the device in again, then clear the fault.',
  overlap: 'The tool is inside something in this scene. Move it out, then engage.',
  'not checked': 'Run hapticctl device check once with this device.',
  stopped: 'Somebody pressed Stop.',
  'emergency stop': 'Release the emergency stop, then clear the fault.',
};

/** Banner of the loop's state, or null: `fault` is the last Fault, `clear` the action of who may clear. */
export function loopBanner(state, fault, clear) {
  if (!state) return null;
  const cause = nameOf(v1.Cause, 'CAUSE_', state.cause);
  if (state.loop_state === v1.LoopState.LOOP_STATE_FAULT) {
    return { title: `Fault: ${cause || 'no cause given'}. No force.`, text: fault?.message || REMEDIES[cause] || '', action: clear && ['Clear fault', clear] };
  }
  if (state.loop_state === v1.LoopState.LOOP_STATE_READY && cause && cause !== 'released') {
    return { title: `The force is off: ${cause}`, text: REMEDIES[cause] ?? '', warn: true };
  }
  return null;
}

/** Banner of a fault that the daemon latches while a recording is shown, or null: `back` is the action of who may show the daemon. */
export function daemonBanner(shown, back) {
  if (!shown?.daemon_fault) return null;
  return { title: 'The daemon, which is not shown now, has a fault', text: shown.daemon_fault, action: back && ['Back to live', back] };
}

const LINKS = ['', 'Connecting to the daemon', '', 'The daemon is silent', 'No route to the daemon', 'The key is refused', 'The daemon speaks another version', 'The daemon is gone'];

/** Banner of the connection, or null while all is well. */
export function linkBanner(link) {
  if (!link || link.state === v1.PageLinkState.PAGE_LINK_STATE_LIVE) return null;
  return { title: LINKS[link.state] || 'No connection to the daemon', text: link.message, warn: link.state === v1.PageLinkState.PAGE_LINK_STATE_CONNECTING };
}

/** Banner about lost packets from 2 % on, where a viewer begins to see it. */
export function lossBanner(link) {
  if (!link || !(link.loss >= 0.02)) return null;
  return { title: `The network loses ${(100 * link.loss).toFixed(0)} % of the packets`, text: 'Events still arrive, once each; pictures and plots have gaps.', warn: true };
}
