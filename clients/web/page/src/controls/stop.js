// Stop: the first thing the page wires, to the session and nothing else. Whatever fails later, button and Escape reach the daemon.

/**
 * `button` and the key Escape, wherever the focus is, ask for Stop; `told(result)` hears the answer, {ok, text}. On a page that may not control
 * the button is off.
 */
export function wireStop({ button, session, told, target = window }) {
  const stop = async () => {
    if (!session.mayControl) return;
    try {
      told(await session.stop());
    } catch (error) {
      told({ ok: false, text: String(error) });
    }
  };
  button.onclick = stop;
  // Captured: no other part of the page can keep the key to itself.
  target.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || event.repeat) return;
    event.preventDefault();
    stop();
  }, { capture: true });
  const show = () => { button.disabled = !session.mayControl; };
  session.addEventListener('change', show);
  show();
}

/** Banner of a Stop that did not arrive, or null. */
export function stopBanner({ ok, text }) {
  return ok ? null : { title: 'Stop did not reach the daemon', text: `${text}. Use the emergency stop of the device, or on the daemon’s machine: hapticctl stop` };
}
