// What things are made of, by their names: lacquer, mother-of-pearl, rosewood, jade, skin. One table for all scenes; whatever has no entry
// gets its own plain colour.
import * as THREE from 'three';

/** First match wins. gloss 0..1; coat: a clear layer above, drawn as such with ?lod=high. */
const SUBSTANCES = [
  [/hui/, { colour: '#f1eddf', gloss: 0.75, coat: 0.6 }],
  [/gum|bridge|yueshan|longyin/, { colour: '#2a1712', gloss: 0.45, coat: 0.4 }],
  [/pegs|zhen/, { colour: '#4f7a62', gloss: 0.6, coat: 0.7 }],
  [/feet|yanzu/, { colour: '#3a241a', gloss: 0.3 }],
  [/guqin/, { colour: '#4c1a12', gloss: 0.82, coat: 1, grain: true }],
  [/nail/, { colour: '#f0cdb9', gloss: 0.6, coat: 0.5 }],
  [/tip|pad/, { colour: '#dba183', gloss: 0.25 }],
  [/palm|hand|finger/, { colour: '#d39a7c', gloss: 0.22 }],
  [/bunny/, { colour: '#cfc6b8', gloss: 0.25 }],
  [/pillar/, { colour: '#6f93a8', gloss: 0.4 }],
  [/plate|wall/, { colour: '#4c5360', gloss: 0.2 }],
  [/bracket/, { colour: '#8b8f96', gloss: 0.5 }],
  [/pipe/, { colour: '#b0703c', gloss: 0.6 }],
];
const PLAIN = ['#8aa0b8', '#b8a58a', '#8ab89b', '#b88a9e', '#a08ab8'];

/** {colour, gloss, coat, grain} of something called `name`, the `index`-th of its kind. */
export function substanceOf(name, index) {
  const found = SUBSTANCES.find(([pattern]) => pattern.test(name));
  return { gloss: 0.35, coat: 0, grain: false, ...(found ? found[1] : { colour: PLAIN[index % PLAIN.length] }) };
}

// Brightest a highlight of full gloss gets: above it a flat lid mirrors the lamp as one white patch.
const MOST_HIGHLIGHT = 0.2;
const LAMP = 2.7; // stage.js, without reflections

export function makeMaterial(substance, high) {
  const material = high
    ? new THREE.MeshPhysicalMaterial({ color: substance.colour, roughness: 0.95 - 0.5 * substance.gloss, metalness: 0,
      clearcoat: 0.3 * substance.coat, clearcoatRoughness: 0.06 })
    : makePhong(substance);
  if (substance.grain) addGrain(material);
  return material;
}

/** The more polished, the smaller its highlight, not the brighter: three.js's lobe peaks at specular (shininess / 2 + 1) / (4 pi). */
function makePhong({ colour, gloss }) {
  const shininess = 8 + 190 * gloss ** 2;
  const peak = (0.5 * shininess + 1) / (4 * Math.PI);
  return new THREE.MeshPhongMaterial({ color: colour, shininess, specular: new THREE.Color('#ffffff').multiplyScalar((MOST_HIGHLIGHT * gloss) / (peak * LAMP)) });
}

/** The haptic tool: where the hand is, as glass that never hides the solid one. */
export function makeGhostMaterial() {
  return new THREE.MeshLambertMaterial({ color: '#7fb8ff', emissive: '#1c4f8f', transparent: true, opacity: 0.3, depthWrite: false,
    polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 });
}

/** Lacquer over wood: streaks along x, and a warm rubbed tone where hands have been. */
function addGrain(material) {
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nvarying vec3 grainPlace;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\ngrainPlace = position;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>
        varying vec3 grainPlace;
        float grainHash(vec2 p) { return fract(sin(dot(p, vec2(127.1, 311.7))) * 43758.5453); }
        float grainNoise(vec2 p) {
          vec2 i = floor(p), f = fract(p);
          f = f * f * (3.0 - 2.0 * f);
          return mix(mix(grainHash(i), grainHash(i + vec2(1, 0)), f.x), mix(grainHash(i + vec2(0, 1)), grainHash(i + 1.0), f.x), f.y);
        }`)
      .replace('#include <color_fragment>', `#include <color_fragment>
        float streaks = grainNoise(grainPlace.xz * vec2(6.0, 160.0));
        float worn = grainNoise(grainPlace.xz * vec2(5.0, 14.0) + 7.0);
        diffuseColor.rgb *= 0.78 + 0.3 * streaks;
        diffuseColor.rgb += vec3(0.085, 0.02, 0.006) * smoothstep(0.45, 0.95, worn);`);
  };
}
