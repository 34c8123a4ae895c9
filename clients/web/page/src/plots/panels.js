// The plots beside the picture: force, torque, penetration margin, ticks, energy. Rows come with every State; canvases are redrawn eight
// times a second, which is all an eye reads. Where States were lost a line has a hole, and what is alone between two holes is a dot.
import 'uplot/dist/uPlot.min.css';
import { LogHistogram, loneRows, sinceFirst, TimeSeries } from './series.js';

const PLOT_PX = 104;
const ROWS = 4096; // 10 s at 400 Hz
const INK = '#8b93a1', GRID = '#262b34';
const X = '#ff6b6b', Y = '#69db7c', Z = '#74a9ff', WHOLE = '#f1f3f5', GOLD = '#ffd54a';

const PLOTS = [
  { id: 'force', title: 'Force on the hand, N', series: [['x', X], ['y', Y], ['z', Z], ['|F|', WHOLE]], least: 2 },
  { id: 'torque', title: 'Torque, mN m', series: [['x', X], ['y', Y], ['z', Z]], least: 20 },
  { id: 'margin', title: 'Penetration margin, µm (0 = touching)', series: [['gap', GOLD]], least: 100 },
  { id: 'energy', title: 'Energy, mJ', series: [['to the hand within 10 s', X], ['strings', GOLD], ['tanks', Z]], least: 1 },
];

export class Panels {
  seconds = 10; // that the plots reach back
  #plots = new Map();
  #data = new Map();
  #ticks = new LogHistogram({ least: 1, most: 4096, capacity: 4096 });

  constructor(holder) {
    this.holder = holder;
    for (const plot of PLOTS) this.#data.set(plot.id, new TimeSeries(plot.series.length, ROWS));
  }

  /** Fetches what draws, and draws from then on; rows are taken before. */
  async open() {
    const { default: uPlot } = await import('uplot');
    for (const plot of PLOTS) this.#plots.set(plot.id, this.#make(uPlot, plot, timeOptions(plot, () => this.seconds)));
    const ticks = { id: 'ticks', title: 'Time of a tick, µs' };
    this.#plots.set('ticks', this.#make(uPlot, ticks, histogramOptions(uPlot, this.#ticks)));
    this.#fit();
    if (typeof ResizeObserver === 'function') new ResizeObserver(() => this.#fit()).observe(this.holder);
    else window.addEventListener('resize', () => this.#fit());
  }

  #make(uPlot, { id, title }, options) {
    const box = document.createElement('section');
    box.className = 'plot';
    box.dataset.plot = id;
    box.innerHTML = `<h3>${title}<output></output></h3>`;
    this.holder.append(box);
    const plot = new uPlot({ ...options, width: 320, height: PLOT_PX }, [[]], box);
    return { plot, box, text: box.querySelector('output') };
  }

  #fit() {
    for (const { plot, box } of this.#plots.values()) {
      const width = Math.max(200, box.clientWidth - 4);
      if (width !== plot.width) plot.setSize({ width, height: PLOT_PX });
    }
  }

  clear() {
    for (const series of this.#data.values()) series.clear();
    this.#ticks.clear();
  }

  /** Takes a State; `toolId` is the tool that is plotted. */
  add(state, toolId) {
    if (state.part_index > 0) return; // other tools of the same tick
    const timeS = state.t_ns * 1e-9;
    const add = (id, values) => this.#data.get(id).add(timeS, values, state.tick);
    const tool = state.tools.find((candidate) => candidate.tool_id === toolId) ?? state.tools[0];
    if (tool?.wrench_h_w.length === 6) {
      const [fx, fy, fz, tx, ty, tz] = tool.wrench_h_w;
      add('force', [fx, fy, fz, Math.hypot(fx, fy, fz)]);
      add('torque', [tx, ty, tz].map((value) => value * 1e3));
      add('margin', [tool.minimum_gap_m * 1e6]);
    }
    if (state.energy) {
      const port = state.energy.tools.find((energy) => energy.tool_id === toolId)?.port_j ?? 0;
      add('energy', [port, state.energy.strings_j, state.energy.tanks_j].map((value) => value * 1e3));
    }
    if (state.timing) this.#ticks.add(state.timing.last_ns * 1e-3);
  }

  /** Redraws what can be seen; `state` is the newest. */
  draw(state) {
    if (this.#plots.size === 0 || this.holder.offsetParent === null) return;
    for (const [id, series] of this.#data) {
      const rows = series.window(this.seconds);
      // What has gone to the hand since the daemon started would dwarf what the strings hold.
      if (id === 'energy') rows[1] = sinceFirst(rows[1]);
      this.#plots.get(id).plot.setData(rows);
    }
    const edges = this.#ticks.counts.map((_, bin) => this.#ticks.edge(bin));
    this.#plots.get('ticks').plot.setData([edges, this.#ticks.counts]);
    if (state) this.#write(state);
  }

  #write(state) {
    const tool = state.tools[0];
    if (tool?.wrench_h_w.length === 6) this.#say('force', `${Math.hypot(...tool.wrench_h_w.slice(0, 3)).toFixed(2)} N`);
    if (tool?.wrench_h_w.length === 6) this.#say('torque', `${(1e3 * Math.hypot(...tool.wrench_h_w.slice(3))).toFixed(1)}`);
    if (tool) this.#say('margin', `${(tool.minimum_gap_m * 1e6).toFixed(0)} µm`);
    if (state.energy) this.#say('energy', `${(state.energy.strings_j * 1e3).toFixed(2)} mJ in strings`);
    const timing = state.timing;
    if (timing?.p50_ns) { // percentiles are not recorded
      const us = (ns) => (ns / 1000).toFixed(0);
      this.#say('ticks', `p50 ${us(timing.p50_ns)} · p99 ${us(timing.p99_ns)} · late ${timing.overruns}`);
    }
  }

  #say(id, text) {
    this.#plots.get(id).text.textContent = text;
  }

  /** What grows with every row of plot `id`, for tests: instant of the newest, or ticks counted. */
  progress(id) {
    return id === 'ticks' ? this.#ticks.seen : this.#data.get(id).newestS;
  }
}

const axis = (more) => ({ stroke: INK, grid: { stroke: GRID, width: 1 }, ticks: { stroke: GRID, width: 1, size: 3 }, font: '10px system-ui',
  gap: 2, ...more });

/** No narrower than `least` either way, so that noise at rest does not fill the plot. */
function rangeOf(least) {
  return (_, low, high) => {
    const top = Math.max(high ?? 0, 0), bottom = Math.min(low ?? 0, 0);
    const room = Math.max(top - bottom, least) * 0.08;
    return [Math.min(bottom, top > least ? 0 : -least * 0.1) - (bottom < 0 ? room : 0), Math.max(top, least * 0.5) + room];
  };
}

function timeOptions({ series, least }, seconds) {
  return {
    legend: { show: false },
    cursor: { show: false },
    scales: { x: { time: false, range: () => [-seconds(), 0] }, y: { range: rangeOf(least) } },
    axes: [axis({ size: 16, values: (_, ticks) => ticks.map((tick) => `${tick} s`) }), axis({ size: 40 })],
    series: [{}, ...series.map(([label, stroke]) => ({ label, stroke, width: 1.25, points: { show: false, size: 3, fill: stroke, filter: loneDots } }))],
  };
}

/** Indices of the rows that are dots, as uPlot asks for them: a line needs two pixels. */
function loneDots({ data, scales, bbox }, index) {
  return loneRows(data[0], data[index], (2 * (scales.x.max - scales.x.min)) / Math.max(1, bbox.width));
}

function histogramOptions(uPlot, histogram) {
  return {
    legend: { show: false },
    cursor: { show: false },
    scales: { x: { time: false, distr: 3, log: 10, range: [histogram.least, histogram.edge(histogram.bins)] },
      y: { range: (_, low, high) => [0, Math.max(8, high ?? 0)] } },
    axes: [axis({ size: 16, values: (_, ticks) => ticks.map((tick) => (tick === null ? '' : Number.isInteger(Math.log10(tick)) ? `${tick}` : '')) }),
      axis({ size: 40 })],
    series: [{}, { stroke: GOLD, fill: '#ffd54a55', paths: uPlot.paths.bars({ size: [0.9, 24] }), points: { show: false } }],
  };
}
