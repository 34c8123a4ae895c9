// What this page may do and asks for: whether it may control, who holds the lease, and requests whose refusals are said in words. One
// request at a time is not needed: the daemon keeps their order.
import { nameOf, v1 } from 'hapticd-stream';

export class Session extends EventTarget {
  #connection;
  mayControl = false;
  maySteer = false; // move and pause a recording that is shown
  lease = null;
  recorder = null;
  scene = null;
  recorded = false; // a recording is shown in place of the daemon
  experimentScreen = null; // the newest ExperimentScreen
  connected = false; // to the gateway

  constructor(connection) {
    super();
    this.#connection = connection;
  }

  get controls() {
    return this.mayControl && this.lease?.yours === true;
  }

  /** Something above changed; panels look again. */
  changed() {
    this.dispatchEvent(new Event('change'));
  }

  lost() {
    Object.assign(this, { mayControl: false, maySteer: false, lease: null, recorder: null, scene: null, recorded: false, experimentScreen: null, connected: false });
    this.changed();
  }

  /** Sends an Item such as {clear: {}}; resolves to the Result, OK or not. Refusals are told with `said`. */
  async ask(item, { quiet = false } = {}) {
    const result = await resultOf(this.#connection.call(item));
    if (!quiet) this.#say(Object.keys(item)[0], result);
    return result;
  }

  /** Stops the force; {ok, text}. */
  async stop() {
    return sentence('stop', await this.ask({ stop: {} }));
  }

  /** Has a recording of the gateway shown to all pages, or with an empty name the daemon. */
  async show(recording) {
    this.#say(recording ? 'replay' : 'live', await resultOf(this.#connection.show(recording)));
  }

  /** Begins, answers or ends an experiment, {begin: {participant, seed}} or {answer: {number, reply, score}} or {end: {}}; resolves to the Result. */
  async experiment(asked) {
    const result = await resultOf(this.#connection.experiment(asked));
    if (!asked.answer || !isOk(result)) this.#say(`${Object.keys(asked)[0]} experiment`, result);
    return result;
  }

  /** What the gateway can show; resolves to the Result, OK or not. */
  listRecordings() {
    return resultOf(this.#connection.listRecordings());
  }

  #say(request, result) {
    // Node 18 has no CustomEvent.
    this.dispatchEvent(Object.assign(new Event('said'), { detail: sentence(request, result) }));
  }

  play(playback) {
    if (!this.maySteer) return;
    this.#connection.play(playback).catch(() => {});
  }
}

/** The Result that is promised, or one that says why none came. */
async function resultOf(promised) {
  try {
    return await promised;
  } catch (error) {
    return { code: v1.ResultCode.RESULT_CODE_FAILED, message: error.message, path: '' };
  }
}

export const isOk = (result) => result.code === v1.ResultCode.RESULT_CODE_OK;

/** {ok, text}: the answer to a request, for people. */
export function sentence(request, result) {
  const what = request.replaceAll('_', ' ');
  if (isOk(result)) return { ok: true, text: `${what}: done` };
  const why = result.message || nameOf(v1.ResultCode, 'RESULT_CODE_', result.code);
  return { ok: false, text: `${what}: ${why}${result.path ? ` (${result.path})` : ''}` };
}
