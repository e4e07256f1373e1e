/** A storey as lines of a plan, y pointing down: what the viewer's map and the plan of free walking share. */
import type { Lines, Plan } from '../scan/scan.ts';
import { shape } from '../elements/svg.ts';
import { type Disc, placeLabel } from './plan_labels.ts';

/** Around what is drawn, metres. */
export const margin = 0.6;
/** Of the longer side: the size of letters, so that they are about 11 pixels high in a panel. */
export const letters = 1 / 34;

/** All lines of a kind as one path. */
function strokes(lines: Lines, name: string): SVGElement {
  let d = '';
  for (let k = 0; k + 3 < lines.length; k += 4) {
    d += `M${lines[k]} ${-lines[k + 1]!}L${lines[k + 2]} ${-lines[k + 3]!}`;
  }
  return shape('path', { d, class: name });
}

/** 1, 2 or 5 times a power of ten: the longest that is not above. */
export function roundLength(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((k) => k * power).find((length) => length <= most * (1 + 1e-9)) ?? power;
}

/** Rooms of a storey whose outline is known. */
export const roomsOf = (plan: Plan | undefined, storey: number): Plan['rooms'] =>
  (plan?.rooms ?? []).filter((room) => room.storey === storey && room.outline.length >= 6);

/** Floors, walls and things of a storey, without names. */
export function storeyLines(plan: Plan | undefined, shown: number): SVGElement[] {
  const storey = plan?.storeys[shown];
  if (!storey) return [];
  const floors = shape('g', { class: 'rooms' },
    ...roomsOf(plan, shown).map(({ outline }) => shape('polygon', { points: outline.map((value, k) => (k % 2 === 0 ? value : -value)).join(' ') })));
  return [floors, strokes(storey.furniture, 'furniture'), strokes(storey.stairs, 'stairs'),
    strokes(storey.windows, 'windows'), strokes(storey.doors, 'doors'), strokes(storey.walls, 'walls')];
}

/** The names of a storey's rooms. @param size of letters, metres @param discs what they leave free, where they can */
export function roomNames(plan: Plan | undefined, shown: number, size: number, discs: readonly Disc[] = []): SVGElement {
  const names = shape('g', { class: 'names', 'font-size': size });
  for (const { name, outline } of roomsOf(plan, shown)) {
    const label = name ? placeLabel(name, outline, size, discs) : undefined;
    label?.lines.forEach((line, k) => {
      names.append(shape('text', { x: label.x, y: label.y + size * (k - (label.lines.length - 1) / 2 + 0.35) }, line));
    });
  }
  return names;
}

/** Rooms, walls, things and names of a storey. @param size of letters, metres */
export const storeyShapes = (plan: Plan | undefined, shown: number, size: number): SVGElement[] =>
  (plan?.storeys[shown] ? [...storeyLines(plan, shown), roomNames(plan, shown, size)] : []);

/** @param most its length, metres */
export function scaleBar(x: number, y: number, most: number, size: number): SVGElement {
  const length = roundLength(most);
  return shape('g', { class: 'scale', 'font-size': size },
    shape('path', { d: `M${x} ${y - size * 0.3}v${size * 0.6}m0 ${-size * 0.3}h${length}m0 ${-size * 0.3}v${size * 0.6}` }),
    shape('text', { x: x + length + size * 0.4, y: y + size * 0.35 }, `${length} m`));
}
