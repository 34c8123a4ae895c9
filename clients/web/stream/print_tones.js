// Prints what is touched and what sounds. usage: node print_tones.js URL [TONES], with the URL that haptic-web prints; TONES: end after so many
import { Connection, StreamModel, streamOf, v1 } from 'hapticd-stream';
import { nodeSocket } from 'hapticd-stream/node';

let left = Number(process.argv[3] ?? Infinity);
const model = new StreamModel({ handlers: { scene: (scene) => console.log(`the scene is ${scene.name}`) } });
const connection = new Connection({
  ...streamOf(process.argv[2] ?? 'http://127.0.0.1:8080/'),
  makeSocket: nodeSocket,
  handlers: {
    event(event) {
      model.take(event);
      const { contact, tone } = event.item ?? {};
      if (contact?.phase === v1.ContactPhase.CONTACT_PHASE_BEGIN) console.log(`tool ${contact.tool_id} touches`);
      if (!tone || left <= 0) return;
      const name = model.scene?.strings[tone.string_index]?.name ?? `string ${tone.string_index}`;
      console.log(`${name} sounds at ${tone.frequency_hz.toFixed(2)} Hz, level ${tone.level.toFixed(2)}`);
      if (--left === 0) connection.close();
    },
    closed: () => model.lost(),
  },
});
connection.open();
