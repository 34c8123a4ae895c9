// All strings and rigid lines of a scene as two meshes: the strings themselves, and around them the envelope of what vibrates. The radius
// is a number per ring and made a length on the screen in the shader, so that a string of 0.7 mm is neither lost nor thick.
import * as THREE from 'three';
import { ringsOfBand } from './string_band.js';
import { add, cross, normalised, perpendicular, scale, subtract } from 'hapticd-stream/vector';

const SIDES = 8;
const LEAST_PX = 1.4;
const LEAST_ROUGH_PX = 2; // without smooth edges a thinner one breaks into dashes
const LEAST_SHADOW_M = 0.0006;
const TAPER = 0.012; // share of a string over which the envelope closes at its ends

export class StringTubes {
  /**
   * `strings`: [{points, radiusM, colour}]. `envelope`: a see-through one that is absent where the radius is 0, with rings for a band. `glow`: what shines by itself,
   * where something a pixel or two wide would else break into facets; black for what is thick enough to be shaded.
   */
  constructor(strings, { envelope = false, glow = '#000000', stage: { high, thrifty: rough } }) {
    Object.assign(this, { envelope, glow });
    const least = envelope ? ringsOfBand(strings.length) : 5;
    this.rings = strings.map((string) => Math.max(least, string.points.length + 2));
    const count = this.rings.reduce((sum, rings) => sum + rings, 0);
    this.geometry = makeGeometry(this.rings, count, strings);
    this.uniforms = { magnify: { value: 1 }, leastPx: { value: envelope ? 0 : rough ? LEAST_ROUGH_PX : LEAST_PX }, metresPerPx: { value: 0.001 } };
    this.mesh = new THREE.Mesh(this.geometry, this.#material(high, rough));
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = !envelope;
    this.mesh.customDepthMaterial = makeShadowMaterial();
    this.mesh.renderOrder = envelope ? 2 : 0;
  }

  /** Where edges are rough (`rough`) a string two pixels wide shows one facet or the next: there it shines by itself, evenly. */
  #material(high, rough) {
    const look = { vertexColors: true, emissive: this.glow };
    const material = this.envelope
      ? new THREE.MeshLambertMaterial({ ...look, transparent: true, opacity: 0.34, depthWrite: false, side: THREE.DoubleSide })
      : high ? new THREE.MeshStandardMaterial({ ...look, roughness: 0.45, metalness: 0.15 })
        : rough && this.glow !== '#000000' ? new THREE.MeshLambertMaterial({ ...look, color: '#555555', emissive: new THREE.Color(this.glow).multiplyScalar(2.2) })
          : new THREE.MeshPhongMaterial({ ...look, shininess: 60, specular: '#666666' });
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nattribute float ringRadius;\nuniform float magnify, leastPx, metresPerPx;')
        .replace('#include <begin_vertex>', `float depth = -(modelViewMatrix * vec4(position, 1.0)).z;
          float halfLeast = 0.5 * leastPx * metresPerPx * max(depth, 0.0);
          vec3 transformed = position + normal * max(ringRadius * magnify, halfLeast);`);
    };
    return material;
  }

  /** Sets string `index` to run along `points` with `radiusM`. */
  set(index, points, radiusM) {
    const isEnd = (t) => this.envelope && (t < TAPER / 2 || t > 1 - TAPER / 2);
    this.setRings(index, points, ringPlaces(points, this.rings[index]).map(({ at, t }) => ({ at, radiusM: isEnd(t) ? 0 : radiusM })));
  }

  /** Sets string `index`, whose axis is `points`, to be drawn through `places`, [{at, radiusM}], as many as this.rings[index]. */
  setRings(index, points, places) {
    const rings = this.rings[index];
    const first = this.rings.slice(0, index).reduce((sum, n) => sum + n, 0);
    const direction = normalised(subtract(points.at(-1), points[0]), [1, 0, 0]);
    const u = perpendicular(direction);
    const v = cross(direction, u);
    const { position, normal, ringRadius } = this.geometry.attributes;
    for (let ring = 0; ring < rings; ++ring) {
      const { at, radiusM } = places[ring];
      for (let side = 0; side < SIDES; ++side) {
        const k = (first + ring) * SIDES + side;
        const angle = (2 * Math.PI * side) / SIDES;
        const n = add(scale(u, Math.cos(angle)), scale(v, Math.sin(angle)));
        position.setXYZ(k, ...at);
        normal.setXYZ(k, ...n);
        ringRadius.setX(k, radiusM);
      }
    }
    position.needsUpdate = normal.needsUpdate = ringRadius.needsUpdate = true;
  }

  get leastPx() {
    return this.uniforms.leastPx.value;
  }

  /** Before each frame: what a pixel is worth at 1 m, and how much radii are magnified. */
  prepare(metresPerPx, magnify) {
    this.uniforms.metresPerPx.value = metresPerPx;
    this.uniforms.magnify.value = magnify;
  }
}

/** The shadow of a string: the same tube, no thinner than the shadow map can show. */
function makeShadowMaterial() {
  const material = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nattribute float ringRadius;')
      .replace('#include <begin_vertex>', `vec3 transformed = position + normal * max(ringRadius, ${LEAST_SHADOW_M});`);
  };
  return material;
}

/** Where the rings of a tube stand: the corners of its axis, doubled at the ends for the taper: [{at, t}]. */
function ringPlaces(points, rings) {
  const ends = [points[0], points.at(-1)];
  const near = [scaleBetween(ends[0], points[1], TAPER), scaleBetween(ends[1], points.at(-2), TAPER)];
  const inner = points.slice(1, -1).map((at) => ({ at, t: 0.5 }));
  const places = [{ at: ends[0], t: 0 }, { at: near[0], t: TAPER }, ...inner, { at: near[1], t: 1 - TAPER }, { at: ends[1], t: 1 }];
  while (places.length < rings) places.splice(2, 0, { at: near[0], t: TAPER });
  return places;
}

const scaleBetween = (a, b, t) => add(a, scale(subtract(b, a), t));

function makeGeometry(rings, count, strings) {
  const geometry = new THREE.BufferGeometry();
  const attribute = (size) => new THREE.BufferAttribute(new Float32Array(count * SIDES * size), size).setUsage(THREE.DynamicDrawUsage);
  geometry.setAttribute('position', attribute(3));
  geometry.setAttribute('normal', attribute(3));
  geometry.setAttribute('ringRadius', attribute(1));
  geometry.setAttribute('color', attribute(3));
  const indices = [];
  let base = 0;
  rings.forEach((number, index) => {
    const colour = new THREE.Color(strings[index].colour);
    for (let k = base * SIDES; k < (base + number) * SIDES; ++k) geometry.attributes.color.setXYZ(k, colour.r, colour.g, colour.b);
    for (let ring = 0; ring + 1 < number; ++ring) {
      for (let side = 0; side < SIDES; ++side) {
        const a = (base + ring) * SIDES + side, b = (base + ring) * SIDES + ((side + 1) % SIDES);
        indices.push(a, a + SIDES, b, b, a + SIDES, b + SIDES);
      }
    }
    base += number;
  });
  geometry.setIndex(indices);
  return geometry;
}
