/** A floor plan of one storey: rooms and walls where they are known, viewpoints, where one looks, a path. */
import { toDegrees } from '../geometry.ts';
import { type Api, type Lines, type Plan, storeyOf } from '../scan.ts';
import { shape } from '../svg.ts';
import type { Viewer } from './viewer.ts';

/** Around what is drawn, metres. */
const margin = 0.6;
/** Of the longer side: the size of letters, so that they are about 11 pixels high in a panel. */
const letters = 1 / 34;

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

/** North (+y) is up. Follows a viewer; a click goes to the nearest viewpoint. */
export class MiniMap {
  readonly element = shape('svg', {});
  private readonly viewer: Viewer;
  private readonly you = shape('g', { class: 'you' });
  private readonly route = shape('g', { class: 'route' });
  private readonly end: () => void;
  private readonly storeyListeners = new Set<(storey: number) => void>();
  private plan: Plan | undefined;
  private path: readonly number[] = [];
  private walk: readonly number[] = [];
  private seen: readonly number[] = [];
  private shown = -1;
  private standing = -1;

  constructor(viewer: Viewer) {
    this.viewer = viewer;
    this.element.classList.add('enfilade-map');
    this.element.setAttribute('role', 'img');
    this.element.setAttribute('aria-label', 'Floor plan; the arrow shows where you look');
    // A sector of 60 degrees that looks up, turned with the heading.
    this.you.append(
      shape('path', { d: 'M0 0 L-0.7 -1.2 A1.4 1.4 0 0 1 0.7 -1.2 Z', class: 'sight' }),
      shape('circle', { r: 0.22 }),
    );
    this.element.addEventListener('click', (event) => this.goNear(event));
    this.end = viewer.onChange(() => this.follow());
    this.follow();
  }

  setPlan(plan: Plan): void {
    this.plan = plan;
    this.drawStorey();
  }

  /** Asks for rooms and walls; without them it stays a map of viewpoints. `names`: of the rooms, too. */
  async loadPlan(api: Api, names: boolean): Promise<void> {
    const plan = await api.plan(this.viewer.scan.scan).catch(() => undefined);
    if (plan) this.setPlan(names ? plan : { ...plan, rooms: plan.rooms.map((room) => ({ ...room, name: '' })) });
  }

  /** A path, a walk that somebody took for it, and squares where the goal is seen; empty: none. */
  setPath(path: readonly number[], walk: readonly number[] = [], seen: readonly number[] = []): void {
    this.path = path;
    this.walk = walk;
    this.seen = seen;
    this.drawRoute();
  }

  /** The storey that is shown, an index of the scan's; -1: none. */
  get storey(): number {
    return this.shown;
  }

  /** Shows a storey until one goes on. */
  showStorey(storey: number): void {
    if (storey === this.shown) return;
    this.shown = storey;
    this.drawStorey();
    for (const listener of this.storeyListeners) listener(storey);
  }

  onStorey(listener: (storey: number) => void): void {
    this.storeyListeners.add(listener);
  }

  /** After the viewer's graph was changed. */
  redraw(): void {
    this.drawStorey();
  }

  dispose(): void {
    this.end();
    this.element.remove();
  }

  private at(viewpoint: number): [number, number] {
    const [x, y] = this.viewer.scan.viewpoints[viewpoint]!.position;
    return [x, -y]; // SVG's y points down
  }

  private get here(): readonly number[] {
    return this.viewer.scan.storeys[this.shown]?.viewpoints ?? [];
  }

  private follow(): void {
    const { viewpoint, heading } = this.viewer.pose;
    if (viewpoint !== this.standing) {
      this.standing = viewpoint;
      this.showStorey(storeyOf(this.viewer.scan, viewpoint));
    }
    const [x, y] = this.at(viewpoint);
    this.you.setAttribute('transform', `translate(${x} ${y}) rotate(${toDegrees(heading)})`);
    this.you.classList.toggle('elsewhere', !this.here.includes(viewpoint));
  }

  private goNear(event: MouseEvent): void {
    const matrix = this.element.getScreenCTM();
    if (!matrix) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    let best: number | undefined;
    let least = 1.5; // metres: farther away one meant nothing
    for (const v of this.here) {
      const [x, y] = this.at(v);
      const away = Math.hypot(x - at.x, y - at.y);
      if (away < least && this.viewer.scan.viewpoints[v]!.rotation) [best, least] = [v, away];
    }
    if (best !== undefined) void this.viewer.go(best);
  }

  private drawStorey(): void {
    const { scan } = this.viewer;
    const here = new Set(this.here);
    const rooms = (this.plan?.rooms ?? []).filter((room) => room.storey === this.shown && room.outline.length >= 6);
    const xs = [...here].map((v) => this.at(v)[0]);
    const ys = [...here].map((v) => this.at(v)[1]);
    for (const { outline } of rooms) {
      outline.forEach((value, k) => (k % 2 === 0 ? xs.push(value) : ys.push(-value)));
    }
    const [left, top] = [Math.min(...xs) - margin, Math.min(...ys) - margin];
    const [width, height] = [Math.max(...xs) + margin - left, Math.max(...ys) + margin - top];
    const size = Math.max(width, height) * letters;
    this.element.setAttribute('viewBox', [left, top, width, height + 2 * size].join(' '));

    const edges = shape('g', { class: 'edges' });
    const dots = shape('g', { class: 'dots' });
    for (const v of here) {
      const [x1, y1] = this.at(v);
      for (const other of scan.viewpoints[v]!.neighbours) {
        if (!here.has(other) || other < v) continue;
        const [x2, y2] = this.at(other);
        edges.append(shape('line', { x1, y1, x2, y2 }));
      }
      dots.append(shape('circle', { cx: x1, cy: y1, r: 0.14 }));
    }
    this.element.replaceChildren(...this.walls(rooms, size), edges, this.route, dots, this.you,
      this.scaleBar(left + margin / 2, top + height + size, width / 3, size));
    this.drawRoute();
    this.follow();
  }

  private walls(rooms: Plan['rooms'], size: number): SVGElement[] {
    const storey = this.plan?.storeys[this.shown];
    if (!storey) return [];
    const floors = shape('g', { class: 'rooms' });
    const names = shape('g', { class: 'names', 'font-size': size });
    for (const { name, outline } of rooms) {
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

  private scaleBar(x: number, y: number, most: number, size: number): SVGElement {
    const length = roundLength(most);
    return shape('g', { class: 'scale', 'font-size': size },
      shape('path', { d: `M${x} ${y - size * 0.3}v${size * 0.6}m0 ${-size * 0.3}h${length}m0 ${-size * 0.3}v${size * 0.6}` }),
      shape('text', { x: x + length + size * 0.4, y: y + size * 0.35 }, `${length} m`));
  }

  private drawRoute(): void {
    const here = new Set(this.here);
    const line = (path: readonly number[], name: string) => {
      const points = path.filter((v) => here.has(v)).map((v) => this.at(v).join(','));
      return shape('polyline', { points: points.join(' '), class: name });
    };
    const ends: [string, number | undefined][] = [
      ['start', this.path[0]],
      ['goal', this.path.at(-1)],
      ['stop', this.walk.at(-1)],
    ];
    this.route.replaceChildren(line(this.path, 'path'), line(this.walk, 'walk'));
    for (const v of this.seen) {
      if (!here.has(v)) continue;
      const [x, y] = this.at(v);
      this.route.append(shape('rect', { x: x - 0.25, y: y - 0.25, width: 0.5, height: 0.5, class: 'seen' }));
    }
    for (const [name, v] of ends) {
      if (v === undefined || !here.has(v)) continue;
      const [cx, cy] = this.at(v);
      this.route.append(shape('circle', { cx, cy, r: name === 'stop' ? 0.45 : 0.3, class: name }));
    }
  }
}
