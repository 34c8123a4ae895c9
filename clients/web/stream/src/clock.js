// The daemon's clock as the page sees it, and when to show what: an instant t_ns is drawn at t_ns + D, as haptic-audio plays it, so that
// eye and ear agree. Offset: PROTOCOL.md section 7, the exchange with the smallest round trip of the last eight.

const EXCHANGES = 8;

export class DaemonClock {
  #exchanges = [];

  /** A PagePong that arrived at `nowS` of the page's clock, s. */
  heard(sentS, daemonNs, nowS) {
    if (!(nowS >= sentS) || !daemonNs) return;
    const roundTripS = nowS - sentS;
    this.#exchanges.push({ roundTripS, offsetS: daemonNs * 1e-9 - (sentS + roundTripS / 2) });
    if (this.#exchanges.length > EXCHANGES) this.#exchanges.shift();
  }

  /** The daemon may be another one, or a recording was moved. */
  forget() {
    this.#exchanges = [];
  }

  get best() {
    return this.#exchanges.reduce((a, b) => (!a || b.roundTripS < a.roundTripS ? b : a), null);
  }

  /** |error of the offset| is at most half the round trip, s; null before the first exchange. */
  get errorS() {
    return this.best && this.best.roundTripS / 2;
  }

  /** The daemon's clock at `pageS` of the page's, ns; null before the first exchange. */
  daemonNs(pageS) {
    return this.best && (pageS + this.best.offsetS) * 1e9;
  }
}

/**
 * Instant of the daemon that is shown at `pageS`, ns. Without a clock that runs with the daemon's (a recording that pauses, virtual time)
 * or before the first exchange it is the newest there is.
 */
export function shownNs({ clock, pageS, delayS, newestNs, steady }) {
  const now = steady ? clock.daemonNs(pageS) : null;
  if (now === null) return newestNs;
  const shown = now - delayS * 1e9;
  // A clock seconds away from the States it comes with is not their clock: a machine that slept, a recording.
  return Math.abs(shown - newestNs) > 2e9 ? newestNs : shown;
}
