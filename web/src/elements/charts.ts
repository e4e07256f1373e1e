/** Drawing numbers: a mean with its interval, and a team's scores over time. */
import { shape } from './svg.ts';

/** A confidence interval and its mean on a scale from `least` to `most`. */
export interface Interval {
  readonly low: number;
  readonly mean: number;
  readonly high: number;
}

const width = 100;

/** Where a value stands on the scale, 0 to 100; a scale without length has everything in its middle. */
export function placeOn(value: number, [least, most]: readonly [number, number]): number {
  if (!(most > least)) return width / 2;
  return Math.min(Math.max(((value - least) / (most - least)) * width, 0), width);
}

/** The scale that all rows of a column share, from the lowest to the highest end. */
export function scaleOf(intervals: readonly Interval[]): readonly [number, number] {
  return [Math.min(...intervals.map(({ low }) => low)), Math.max(...intervals.map(({ high }) => high))];
}

export function intervalBar({ low, mean, high }: Interval, scale: readonly [number, number], label: string): SVGElement {
  const at = (value: number) => placeOn(value, scale).toFixed(1);
  return shape('svg', { class: 'interval', viewBox: `0 0 ${width} 8`, preserveAspectRatio: 'none', role: 'img', 'aria-label': label },
    shape('title', {}, label),
    shape('line', { class: 'scale', x1: 0, x2: width, y1: 4, y2: 4 }),
    shape('line', { class: 'span', x1: at(low), x2: at(high), y1: 4, y2: 4 }),
    shape('line', { class: 'mean', x1: at(mean), x2: at(mean), y1: 0, y2: 8 }));
}

/** A score of a team. */
export interface Point {
  readonly team: string;
  /** Milliseconds since 1970. */
  readonly time: number;
  readonly value: number;
  readonly name: string;
}

/** A team's best so far, after each of its submissions, and whether it was that submission that is best. */
export function bestSoFar(points: readonly Point[]): readonly (Point & { readonly best: number; readonly better: boolean })[] {
  let best = -Infinity;
  return [...points].sort((a, b) => a.time - b.time).map((point) => {
    const better = point.value > best;
    best = Math.max(best, point.value);
    return { ...point, best, better };
  });
}

/** Round numbers from below `least` to above `most`, four or five of them. */
export function ticksOf(least: number, most: number): readonly number[] {
  const span = Math.max(most - least, 1e-9);
  const power = 10 ** Math.floor(Math.log10(span / 4));
  const step = [1, 2, 5, 10].map((k) => k * power).find((one) => span / one <= 5)!;
  const first = Math.floor(least / step + 1e-9) * step;
  const ticks: number[] = [];
  for (let k = 0; k === 0 || ticks.at(-1)! < most - step * 1e-6; ++k) ticks.push(Number((first + k * step).toFixed(10)));
  return ticks;
}

/** All teams' best scores as steps over time; one team's with its submissions. Its letters keep their size, so phones have a drawing of their own. */
export function progressChart(points: readonly Point[], team: string, label: string, narrow = matchMedia('(max-width: 45rem)').matches): SVGElement {
  const [w, h] = narrow ? [358, 240] : [960, 280];
  const [left, right, top, bottom] = [36, 12, 12, 28];
  const times = points.map(({ time }) => time);
  const [begin, end] = [Math.min(...times), Math.max(...times)];
  const ticks = ticksOf(Math.min(...points.map(({ value }) => value)), Math.max(...points.map(({ value }) => value)));
  const x = (time: number) => left + (placeOn(time, [begin, end]) / width) * (w - left - right);
  const y = (value: number) => h - bottom - (placeOn(value, [ticks[0]!, ticks.at(-1)!]) / width) * (h - top - bottom);
  const pathOf = (list: ReturnType<typeof bestSoFar>) => list.map(({ time, best }, k) =>
    (k === 0 ? `M${x(time).toFixed(1)} ${y(best).toFixed(1)}` : `H${x(time).toFixed(1)}V${y(best).toFixed(1)}`)).join('') + `H${w - right}`;
  const byTeam = new Map(points.map((point) => [point.team, points.filter((other) => other.team === point.team)]));
  const chosen = bestSoFar(byTeam.get(team) ?? []);
  const day = (time: number) => new Date(time).toISOString().slice(0, 10);
  return shape('svg', { class: 'chart', viewBox: `0 0 ${w} ${h}`, role: 'img', 'aria-label': label },
    shape('g', { class: 'grid' }, ...ticks.flatMap((tick) => [
      shape('line', { x1: left, x2: w - right, y1: y(tick), y2: y(tick) }),
      shape('text', { x: left - 8, y: y(tick) + 4, 'text-anchor': 'end' }, String(tick))])),
    shape('text', { x: left, y: h - 8 }, day(begin)),
    ...(day(end) === day(begin) ? [] : [shape('text', { x: w - right, y: h - 8, 'text-anchor': 'end' }, day(end))]),
    ...[...byTeam].filter(([name]) => name !== team).map(([, list]) => shape('path', { class: 'other', d: pathOf(bestSoFar(list)) })),
    ...(chosen.length > 0 ? [shape('path', { class: 'line', d: pathOf(chosen) })] : []),
    ...chosen.map(({ time, value, name, better }) => shape('circle', { class: better ? 'dot better' : 'dot', cx: x(time), cy: y(value), r: 5 },
      shape('title', {}, `${name}: ${value.toFixed(1)}, ${day(time)}`))));
}
