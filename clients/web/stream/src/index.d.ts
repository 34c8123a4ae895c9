// Types of index.js. Instants are ns of the daemon's clock as plain numbers, lengths m, forces N: see the .proto files.
import * as v1 from './generated/v1.js';
import type { Pose, Vector } from './vector.js';

/** The messages: `v1.State` is a type, and `v1.State.decode(bytes)` reads one. */
export { v1 };

// The connection.

/** What a Connection needs of a WebSocket. */
export interface Socket {
  binaryType: string;
  readonly readyState: number;
  onopen: ((event: any) => void) | null;
  onmessage: ((event: any) => void) | null;
  onclose: ((event: any) => void) | null;
  send(data: Uint8Array): void;
  close(): void;
}

/** {address, token} of the WebSocket to the gateway whose page has this URL. */
export function streamOf(url: string): { address: string; token: string };
/** Subprotocols to offer: without a token one only looks. */
export function subprotocols(token: string): string[];
/** Pause before attempt `n` (from 0) to connect, ms. */
export function pauseMs(n: number): number;

export interface ConnectionOptions {
  /** ws://HOST:PORT/stream, see streamOf. */
  address: string;
  /** Of the URL that haptic-web prints; without it one only looks. */
  token?: string;
  handlers?: { event?(event: v1.PageEvent): void; opened?(): void; closed?(): void };
  /** A clock that never goes back, s. */
  pageS?: () => number;
  /** Before version 22 Node has no WebSocket: see nodeSocket. */
  makeSocket?: (url: string, protocols: string[]) => Socket;
}

/** The WebSocket to haptic-web. It comes back by itself when it is lost; requests without an answer have failed then. */
export class Connection {
  constructor(options: ConnectionOptions);
  /** PageEvents that the gateway left out because this client was too slow. */
  skippedEvents: number;
  /** What came and was no PageEvent; it is left out. */
  damagedEvents: number;
  /** Bytes received. */
  bytes: number;
  /** Why haptic-web closed it, while it may not come back for that; else empty. */
  goodbye: string;
  readonly isOpen: boolean;
  /** Connects, and again after every loss; nothing changes where it is connected or connecting. */
  open(): void;
  /** Ends it until open(). What waits for an answer fails, and closed() is called, before it returns. */
  close(): void;
  /** Sends an Item, such as {clear: {}}, to the daemon; its Result, OK or not. */
  call(item: v1.Plain<v1.Item>): Promise<v1.Result>;
  /** Seeks, pauses or paces a recording. */
  play(playback: v1.Plain<v1.PagePlayback>): Promise<null>;
  /** Shows a recording of the gateway's folder, or with an empty name the daemon. */
  show(recording: string): Promise<v1.Result>;
  /** What the gateway can show. */
  listRecordings(): Promise<v1.Result>;
  /** Begins, answers or ends an experiment. */
  experiment(asked: v1.Plain<v1.PageExperiment>): Promise<v1.Result>;
}

// What has arrived.

export interface Shape {
  mesh: { hash: string; size: number } | null;
  tree: { hash: string; size: number } | null;
  /** x y z r of each sphere, m. */
  spheres: Float64Array | null;
}
export interface StringModel {
  name: string;
  /** Corners of the axis at rest, world, m. */
  points: number[][];
  radiusM: number;
  frequencyHz: number;
}
export interface Box {
  lower: number[];
  upper: number[];
  centre: number[];
  size: number;
}
export interface SceneModel {
  id: number;
  name: string;
  description: string;
  scene: v1.Scene;
  tools: { id: number; name: string; pose: Pose; parts: (Shape & { name: string; pose: Pose })[] }[];
  bodies: (Shape & { name: string; pose: Pose })[];
  lines: { name: string; points: number[][]; radiusM: number }[];
  strings: StringModel[];
  box: Box;
  rateHz: number;
  virtual: boolean;
  parameters: v1.ParameterInfo[];
  serverVersion: string;
}
/** A SceneInfo as shapes with the hashes of their files, strings and lines as chains of corners, and the box around all. */
export function sceneModel(info: v1.SceneInfo): SceneModel;
export function triples(values: ArrayLike<number>): number[][];
export function sagging(a: Vector, b: Vector, sag: number): number[][];
export function boxAround(points: Vector[]): Box;
export function flatPart(sphere: readonly number[], to: Vector): { point: number[]; normal: number[] };
export function isLarge(radiusM: number): boolean;

/** The last half second of States, and what lies between two of them. */
export class StateBuffer {
  readonly newest: v1.State | null;
  clear(): void;
  add(state: v1.State): void;
  /** The tick at `ns`; before the oldest it is the oldest, after the newest the newest. */
  at(ns: number): v1.State | null;
}

/** The daemon's clock as seen here. */
export class DaemonClock {
  heard(sentS: number, daemonNs: number, nowS: number): void;
  forget(): void;
  readonly best: { roundTripS: number; offsetS: number } | null;
  /** |error of the offset| is at most this, s. */
  readonly errorS: number | null;
  daemonNs(pageS: number): number | null;
}
/** Instant of the daemon that is shown at `pageS`, ns. */
export function shownNs(at: { clock: DaemonClock; pageS: number; delayS: number; newestNs: number; steady: boolean }): number;

/** What strings sound like at an instant, by the events StringSounding and the States that repeat them. */
export class StringSoundings {
  clear(): void;
  add(sounding: v1.StringSounding): void;
  addState(state: v1.State): void;
  /** The newest message about string `index` that was true by `ns`; null where there is none. */
  at(index: number, ns: number): v1.StringSounding | null;
}
/** Pitch and amplitudes at `ns`, if nothing has been told since. */
export function soundingAt(sounding: v1.StringSounding, ns: number): { frequencyHz: number; partialsM: number[] };
/** How far partials reach together at `s` in [0, 1] of the part that sounds, m. */
export function swingAt(partialsM: readonly number[], s: number): number;

/** The band that a string swings in: over which part, from A, and with which amplitudes of its partials. */
export interface StringBand {
  from: number;
  to: number;
  partialsM: readonly number[];
  widestM: number;
}

/** How strings look at an instant, by the events StringRadius and StringSounding. */
export class StringMotion {
  readonly soundings: StringSoundings;
  clear(): void;
  add(event: v1.StringRadius): void;
  /** Envelope of string `index` at `ns`, m; null where no event says anything. */
  envelope(index: number, ns: number): number | null;
}
export function decayed(event: v1.StringRadius, ns: number): number;
export interface StringShape {
  radiusM: number;
  envelopeM: number;
  deflection: readonly number[];
  lambda: number;
  phase: v1.StringPhase;
  /** Where and how far it swings, where that is told; envelopeM is the widest of it. null: envelopeM all along. */
  band: StringBand | null;
}
export function stringShape(string: StringModel, index: number, state: v1.StringState | undefined, motion: StringMotion, ns: number): StringShape;

/** Who controls, for whoever does: kept up to date by a StreamModel. */
export interface StreamSession {
  changed(): void;
  lost(): void;
  mayControl?: boolean;
  maySteer?: boolean;
  connected?: boolean;
  recorded?: boolean;
  lease?: v1.LeaseInfo | null;
  recorder?: v1.RecordInfo | null;
  scene?: SceneModel | null;
  experimentScreen?: v1.ExperimentScreen | null;
}

/** What has arrived, put where it belongs. */
export class StreamModel {
  constructor(options?: {
    session?: StreamSession;
    handlers?: { scene?(scene: SceneModel): void; state?(state: v1.State): void; playback?(playback: v1.PagePlayback): void; shown?(): void };
    pageS?: () => number;
  });
  readonly clock: DaemonClock;
  readonly states: StateBuffer;
  readonly motion: StringMotion;
  /** Not yet given out by dueTones, oldest first. */
  tones: v1.Tone[];
  welcome: v1.PageWelcome | null;
  link: v1.PageLink | null;
  fault: v1.Fault | null;
  playback: v1.PagePlayback | null;
  shown: v1.PageShown | null;
  scene: SceneModel | null;
  received: { states: number };
  session: StreamSession;
  /** A recording is shown, not the daemon. */
  readonly recorded: boolean;
  /** Time of the daemon goes on as ours does. */
  readonly steady: boolean;
  take(event: v1.PageEvent): void;
  /** The connection is lost: nothing that came before goes on. */
  lost(): void;
  /** Instant of the daemon that is shown now, ns; null without any State. */
  shownNs(): number | null;
  /** Tones whose instant has come at `ns`, each once. */
  dueTones(ns: number): v1.Tone[];
}

// What the scene is made of.

/** Corners of a string's axis with its present bend. */
export function bentAxis(string: { points: number[][] }, shape?: { deflection: readonly number[]; lambda: number }): number[][];
export function nearestOnSegment(a: Vector, b: Vector, p: Vector): { point: number[]; t: number; distance: number };
/** Nearest of the strings to a tool of spheres x y z r at `pose`. */
export function nearestString(spheres: Float64Array, pose: Pose, strings: { points: number[][]; radiusM: number }[]):
  { index: number; distanceM: number; onString: number[]; onTool: number[] } | null;
/** Leaves and levels, coarsest first, of a sphere-tree file, x y z r each. Error where it is none, or ends too early. */
export function readSphereTree(bytes: Uint8Array): { leaves: Float64Array; levels: Float64Array[] };
export function levelWithin(levels: Float64Array[], most: number): Float64Array;
/** A message as protobuf text format, as far as scenes need it. */
export function textOf(message: object, indent?: string): string;
/** Name of an enum's value without its prefix: nameOf(v1.Cause, 'CAUSE_', 9) is 'device lost'. */
export function nameOf(values: object, prefix: string, value: number): string;
/** Lower-case hexadecimal. */
export function hex(bytes: Uint8Array): string;
