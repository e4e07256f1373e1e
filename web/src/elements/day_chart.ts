/** What was done day by day, as bars. */
import { ticksOf } from './charts.ts';
import { counted, make } from './page.ts';
import { shape } from './svg.ts';

interface DayCount {
  /** "2026-11-30", of UTC. */
  readonly day: string;
  readonly submitted: number;
  readonly reviewed: number;
}

const dayMs = 86_400_000;

/** The days from the first to the last, those without work among them; of many the last `most`. */
export function everyDay(days: readonly DayCount[], most = 60): DayCount[] {
  const [first, last] = [days[0], days.at(-1)];
  if (!first || !last) return [];
  const known = new Map(days.map((one) => [one.day, one]));
  const end = Date.parse(last.day);
  const begin = Math.max(Date.parse(first.day), end - (most - 1) * dayMs);
  const all: DayCount[] = [];
  for (let time = begin; time <= end; time += dayMs) {
    const day = new Date(time).toISOString().slice(0, 10);
    all.push(known.get(day) ?? { day, submitted: 0, reviewed: 0 });
  }
  return all;
}

/** Two bars a day, and what they are: what workers submitted, and what was reviewed. Nothing without a day. */
export function dayChart(days: readonly DayCount[]): Element[] {
  const all = everyDay(days);
  if (all.length === 0) return [];
  const [w, h, left, bottom, top] = [360, 96, 28, 18, 8];
  const most = ticksOf(0, Math.max(...all.map(({ submitted, reviewed }) => Math.max(submitted, reviewed)), 1)).at(-1)!;
  const step = Math.min((w - left) / all.length, 24);
  const y = (count: number) => h - bottom - (count / most) * (h - bottom - top);
  const bar = (name: string, k: number, offset: number, count: number, said: string) =>
    shape('rect', { class: name, x: (left + step * (k + offset)).toFixed(1), width: (step * 0.4).toFixed(1), y: y(count).toFixed(1),
      height: (h - bottom - y(count)).toFixed(1) }, shape('title', {}, said));
  const sum = (of: 'submitted' | 'reviewed') => all.reduce((total, one) => total + one[of], 0);
  const label = `${counted(sum('submitted'), 'task')} submitted and ${sum('reviewed')} reviewed from ${all[0]!.day} to ${all.at(-1)!.day}`;
  const key = (name: string) => make('span', { class: name }, name);
  const note = make('p', { class: 'note days-key' }, 'By day (UTC): ', key('submitted'), ' ', key('reviewed'));
  return [note, shape('svg', { class: 'chart days', viewBox: `0 0 ${w} ${h}`, role: 'img', 'aria-label': label },
    shape('g', { class: 'grid' }, ...[0, most].flatMap((tick) => [
      shape('line', { x1: left, x2: w, y1: y(tick), y2: y(tick) }),
      shape('text', { x: left - 6, y: y(tick) + 4, 'text-anchor': 'end' }, String(tick))])),
    ...all.flatMap(({ day, submitted, reviewed }, k) => [
      bar('submitted', k, 0.1, submitted, `${day}: ${submitted} submitted`), bar('reviewed', k, 0.5, reviewed, `${day}: ${reviewed} reviewed`)]),
    shape('text', { x: left, y: h - 3 }, all[0]!.day),
    ...(all.length > 1 && step * all.length > 150
      ? [shape('text', { x: left + step * all.length, y: h - 3, 'text-anchor': 'end' }, all.at(-1)!.day)] : []))];
}
