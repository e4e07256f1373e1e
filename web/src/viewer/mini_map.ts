/** A floor plan of one storey: rooms and walls where they are known, viewpoints, where one looks, a path. */
import { shape } from '../elements/svg.ts';
import { degrees, toDegrees } from '../geometry/geometry.ts';
import { type Plan, storeyOf } from '../scan/scan.ts';
import type { Api } from '../server/api.ts';
import { letters, margin, roomNames, roomsOf, scaleBar, storeyLines } from './plan_shapes.ts';
import type { Viewer } from './viewer.ts';

/** What a map follows: a viewer, or what stands still. */
export type MapSource = Pick<Viewer, 'scan' | 'pose' | 'onChange' | 'go'>;

/** Metres, of a viewpoint's dot; and the room that it takes with its number. */
const dot = 0.14;
const numbered = 0.35;

/** A sector that looks up, as wide as what one sees. @param opening from side to side, radians */
function sight(opening: number): string {
  const [x, y] = [1.4 * Math.sin(opening / 2), 1.4 * Math.cos(opening / 2)].map((value) => value.toFixed(3)) as [string, string];
  return `M0 0 L-${x} -${y} A1.4 1.4 0 0 1 ${x} -${y} Z`;
}

/** North (+y) is up. Follows a viewer; a click goes to the nearest viewpoint. */
export class MiniMap {
  readonly element = shape('svg', {});
  private readonly viewer: MapSource;
  private readonly numbers: boolean;
  private readonly sight = shape('path', { class: 'sight' });
  private readonly you = shape('g', { class: 'you' });
  private readonly route = shape('g', { class: 'route' });
  private readonly end: () => void;
  private readonly storeyListeners = new Set<(storey: number) => void>();
  private plan: Plan | undefined;
  private path: readonly number[] = [];
  private walk: readonly number[] = [];
  private seen: readonly number[] = [];
  private marked: readonly number[] = [];
  private shown = -1;
  private standing = -1;

  /** @param numbers whether viewpoints have theirs */
  constructor(viewer: MapSource, { numbers = false } = {}) {
    this.viewer = viewer;
    this.numbers = numbers;
    this.element.classList.add('enfilade-map');
    this.element.setAttribute('role', 'img');
    this.element.setAttribute('aria-label', 'Floor plan; the arrow shows where you look');
    this.you.append(this.sight, shape('circle', { r: 0.22 }));
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

  /** A path, an agent's walk for it, and squares where the goal is seen; empty: none. */
  setPath(path: readonly number[], walk: readonly number[] = [], seen: readonly number[] = []): void {
    this.path = path;
    this.walk = walk;
    this.seen = seen;
    this.drawRoute();
  }

  /** Rings around viewpoints that something else on the page is about; empty: none. */
  setMarked(viewpoints: readonly number[]): void {
    this.marked = viewpoints;
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
    const { viewpoint, heading, vfov } = this.viewer.pose;
    if (viewpoint !== this.standing) {
      this.standing = viewpoint;
      this.showStorey(storeyOf(this.viewer.scan, viewpoint));
    }
    const [x, y] = this.at(viewpoint);
    this.you.setAttribute('transform', `translate(${x} ${y}) rotate(${toDegrees(heading)})`);
    this.sight.setAttribute('d', sight(Math.min(vfov * 1.2, degrees(130)))); // pictures are wider than high
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
    if (best !== undefined) void this.viewer.go(best, true);
  }

  private drawStorey(): void {
    const { scan } = this.viewer;
    const here = new Set(this.here);
    const rooms = roomsOf(this.plan, this.shown);
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
    const numbers = shape('g', { class: 'numbers', 'font-size': size * 0.8 });
    for (const v of here) {
      const [x1, y1] = this.at(v);
      for (const other of scan.viewpoints[v]!.neighbours) {
        if (!here.has(other) || other < v) continue;
        const [x2, y2] = this.at(other);
        edges.append(shape('line', { x1, y1, x2, y2 }));
      }
      dots.append(shape('circle', { cx: x1, cy: y1, r: dot }));
      if (this.numbers) numbers.append(shape('text', { x: x1, y: y1 - 1.5 * dot }, String(v)));
    }
    const discs = [...here].map((v) => ({ x: this.at(v)[0], y: this.at(v)[1], radius: this.numbers ? numbered : 2 * dot }));
    this.element.replaceChildren(...storeyLines(this.plan, this.shown), edges, this.route, dots,
      roomNames(this.plan, this.shown, size, discs), numbers, this.you,
      scaleBar(left + margin / 2, top + height + size, width / 3, size));
    this.drawRoute();
    this.follow();
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
    for (const v of new Set(this.marked)) {
      if (!here.has(v)) continue;
      const [cx, cy] = this.at(v);
      this.route.append(shape('circle', { cx, cy, r: 0.5, class: 'marked' }));
    }
    for (const [name, v] of ends) {
      if (v === undefined || !here.has(v)) continue;
      const [cx, cy] = this.at(v);
      this.route.append(shape('circle', { cx, cy, r: name === 'stop' ? 0.45 : 0.3, class: name }));
    }
  }
}
