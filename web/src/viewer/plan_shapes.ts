/** A storey as lines of a plan, y pointing down: what the viewer's map and the plan of free walking share. */
import type { Lines, Plan } from '../scan/scan.ts';
import { shape } from '../elements/svg.ts';

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

/** Rooms, walls and things of a storey. @param size of letters, metres */
export function storeyShapes(plan: Plan | undefined, shown: number, size: number): SVGElement[] {
  const storey = plan?.storeys[shown];
  if (!storey) return [];
  const floors = shape('g', { class: 'rooms' });
  const names = shape('g', { class: 'names', 'font-size': size });
  for (const { name, outline } of roomsOf(plan, shown)) {
    const points = outline.map((value, k) => (k % 2 === 0 ? value : -value));
    floors.append(shape('polygon', { points: points.join(' ') }));
    const [px, py] = [0, 1].map((which) => points.filter((_, k) => k % 2 === which)) as [number[], number[]];
    const room = { left: Math.min(...px), right: Math.max(...px), top: Math.min(...py), bottom: Math.max(...py) };
    const words = name.split(' ');
    const wide = 0.56 * size * Math.max(...words.map((word) => word.length));
    // Names that do not fit say less than the furniture that they would hide.
    if (!name || wide > room.right - room.left || words.length * size > room.bottom - room.top) continue;
    words.forEach((word, k) => {
      names.append(shape('text', {
        x: (room.left + room.right) / 2,
        y: (room.top + room.bottom) / 2 + size * (k - (words.length - 1) / 2 + 0.35),
      }, word));
    });
  }
  return [floors, strokes(storey.furniture, 'furniture'), strokes(storey.stairs, 'stairs'),
    strokes(storey.windows, 'windows'), strokes(storey.doors, 'doors'), strokes(storey.walls, 'walls'), names];
}

/** @param most its length, metres */
export function scaleBar(x: number, y: number, most: number, size: number): SVGElement {
  const length = roundLength(most);
  return shape('g', { class: 'scale', 'font-size': size },
    shape('path', { d: `M${x} ${y - size * 0.3}v${size * 0.6}m0 ${-size * 0.3}h${length}m0 ${-size * 0.3}v${size * 0.6}` }),
    shape('text', { x: x + length + size * 0.4, y: y + size * 0.35 }, `${length} m`));
}
