// All of the package but what only Node has. Names, units and frames are those of proto/hapticd/v1.
export { DaemonClock, shownNs } from './clock.js';
export { Connection, pauseMs, streamOf, subprotocols } from './connection.js';
export { bentAxis, nearestOnSegment, nearestString } from './nearest_string.js';
export { boxAround, flatPart, isLarge, sagging, sceneModel, triples } from './scene_model.js';
export { levelWithin, readSphereTree } from './sphere_tree.js';
export { StateBuffer } from './state_buffer.js';
export { StreamModel } from './stream_model.js';
export { decayed, stringShape, StringMotion } from './string_motion.js';
export { soundingAt, StringSoundings, swingAt } from './string_sounding.js';
export { textOf } from './text_format.js';
export { hex, nameOf, v1 } from './wire.js';
