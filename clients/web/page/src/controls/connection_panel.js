// How good the connection is, in numbers: daemon to gateway, gateway to page, and what this page does with it.
import { nameOf, v1 } from 'hapticd-stream';
import { make } from './dom.js';

const ms = (seconds) => (seconds > 0 ? `${(seconds * 1e3).toFixed(2)} ms` : '–');

/** What is shown, for people. */
export function shownText(shown) {
  if (shown?.source !== v1.PageSource.PAGE_SOURCE_RECORDING) return 'live';
  return `${shown.recording || 'a recording'}${shown.cut_off ? ', cut off' : ''}${shown.tools_only ? ', tools alone: strings and contacts are in newer recordings' : ''}`;
}

/** [name, value] rows from what is known. */
export function connectionRows({ welcome, shown, link, clock, connection, rates, scene, drawn }) {
  const rows = [['gateway', welcome ? `haptic-web ${welcome.version}` : 'not connected'],
    ['source', shownText(shown)],
    ['daemon', scene ? `hapticd ${scene.serverVersion}` : '–'],
    ['link to the daemon', link ? nameOf(v1.PageLinkState, 'PAGE_LINK_STATE_', link.state) : '–'],
    ['round trip', ms(link?.round_trip_s)],
    ['packets lost', link ? `${(100 * link.loss).toFixed(1)} %` : '–'],
    ['clock offset', link ? `${(1e3 * link.clock_offset_s).toFixed(3)} ms ± ${(1e3 * link.clock_error_s).toFixed(3)}` : '–'],
    ['from the daemon', link ? `${(link.bytes_per_s / 1000).toFixed(1)} kB/s` : '–'],
    ['States dropped for this page', link ? String(link.dropped_states) : '–'],
    ['events missed', String(connection.skippedEvents)],
    ['to this page', `${(rates.bytes / 1000).toFixed(1)} kB/s, ${rates.states} States/s`],
    ['page’s clock', clock.errorS === null ? '–' : `± ${(1e3 * clock.errorS).toFixed(2)} ms`],
    ['shown after the event', welcome ? ms(welcome.presentation_delay_s) : '–'],
    ['frames', `${rates.frames} /s`],
    ['triangles', drawn ? String(drawn.triangles) : '–'],
    ['files missing', drawn?.missing ? `${drawn.missing}: drawn as spheres, or not at all` : 'none']];
  return rows;
}

export class ConnectionPanel {
  constructor(holder) {
    this.list = make('dl', { id: 'connection-list' });
    holder.append(this.list);
  }

  show(known) {
    if (this.list.offsetParent === null) return;
    this.list.replaceChildren(...connectionRows(known).flatMap(([name, value]) => [make('dt', {}, name), make('dd', { 'data-name': name }, value)]));
  }
}
