// Live parameters as rows to edit: SceneInfo names them with [*] for every index, GetParameters answers with each by its own path.

/** Rows {path, group, label, unit, minimum, maximum, value} from ParameterInfo and the values of GetParameters, scalars only. */
export function parameterRows(infos, assignments, scene) {
  const byPattern = new Map(infos.map((info) => [info.path, info]));
  return assignments.filter((assignment) => typeof assignment.number === 'number').map((assignment) => {
    const pattern = assignment.path.replace(/\[\d+\]/g, '[*]');
    const info = byPattern.get(pattern) ?? byPattern.get(assignment.path) ?? {};
    return { path: assignment.path, value: assignment.number, unit: info.unit && info.unit !== '1' ? info.unit : '',
      minimum: info.minimum, maximum: info.maximum, ...labelOf(assignment.path, scene) };
  });
}

/** strings[3].tension_n -> group "string G2", label "tension". */
export function labelOf(path, scene) {
  const [, list, index, rest] = path.match(/^(\w+)\[(\d+)\]\.(.+)$/) ?? [];
  if (!list) return { group: 'scene', label: wordsOf(path) };
  const thing = scene?.[list]?.[Number(index)];
  return { group: `${list.replace(/s$/, '')} ${thing?.name ?? index}`, label: wordsOf(rest) };
}

const UNITS = /_(n|pa|hz|s|m|us|n_per_m|n_s_per_m|kg_per_m|m_per_s)$/;

function wordsOf(path) {
  return path.split('.').map((part) => part.replace(UNITS, '')).join(' ').replaceAll('_', ' ');
}

/** Slider 0..1 <-> value: by decades where the range spans many and is positive, else evenly. */
export function sliderScale(row) {
  const around = Math.max(Math.abs(row.value), 1e-6);
  let low = Math.max(row.minimum ?? 0, around / 10);
  let high = Math.min(row.maximum ?? Infinity, around * 10);
  if (!(row.value > 0)) [low, high] = [row.minimum ?? 0, Math.min(row.maximum ?? 1, 1)];
  const even = low <= 0 || high <= low;
  return {
    toValue: (t) => (even ? low + (high - low) * t : low * (high / low) ** t),
    toSlider: (value) => (even ? (value - low) / (high - low || 1) : Math.log(value / low) / Math.log(high / low)),
  };
}

/** A number for people: four digits. */
export function shortNumber(value) {
  if (value === 0) return '0';
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(3).replace(/\.?0+e/, 'e') : String(Number(value.toPrecision(4)));
}
