/** First person in a panorama, as a part of any page. */
import {
  apply, type Camera, degrees, type Direction, directionTo, norm, project, subtract, type Vec3, worldFromCamera, wrapHeading,
} from '../geometry/geometry.ts';
import { halfFieldOfView, navigable, type Step } from '../scan/navigation.ts';
import { type Layer, type Scan, viewpointIndex } from '../scan/scan.ts';
import { Api } from '../server/api.ts';
import { Controls } from './controls.ts';
import { floorBelow, type Mark } from './discs.ts';
import { Flight, type Moment } from './flight.ts';
import { type Outline, OutlineLayer } from './outline_layer.ts';
import { type Panorama, Pictures } from './panorama.ts';
import { type Passage, Stage } from './stage.ts';
import { reachOf } from './surround.ts';

/** Where one stands and looks. */
export interface Pose extends Direction {
  /** Index into Scan.viewpoints. */
  readonly viewpoint: number;
  /** Vertical opening, radians. */
  readonly vfov: number;
}

export interface ViewerOptions extends Partial<Direction> {
  readonly scan: string;
  /** An id; absent: the first viewpoint that has pictures. */
  readonly viewpoint?: string;
  /** An id: looks there first, if no heading is given. Absent: to where most is to be seen. */
  readonly towards?: string;
  readonly vfov?: number;
  /** The server's address; absent: that of the page. */
  readonly server?: string;
  /** Absent: one may look and go everywhere. */
  readonly rules?: Rules;
}

/** What one may see and do, where that is less than everything. */
export interface Rules {
  /** Radians: only steps that lie within this angle of the heading can be taken. */
  readonly within: number;
  /** One looks so far up and down at most, radians. */
  readonly mostElevation: number;
  /** The vertical opening, which stays, radians. */
  readonly vfov: number;
  /** Width of the picture divided by its height. */
  readonly aspect: number;
}

/** What an agent of R2R sees: 640 x 480 at 60 degrees, three rows of views, MatterSim's linear field of view. */
export const agentRules: Rules = {
  within: halfFieldOfView({ width: 640, height: 480, vfov: degrees(60) }),
  mostElevation: degrees(30),
  vfov: degrees(60),
  aspect: 640 / 480,
};

const leastVfov = degrees(25);
const mostVfov = degrees(100);
/** A disc is hit within this many pixels: a finger's width. */
const reach = 36;
/** Of a glide: as long as it takes to see where one gets to. A fade is no motion, and shorter. */
const glideSeconds = (metres: number): number => Math.min(Math.max(0.4 + 0.25 * metres, 0.7), 1.4);
const fadeSeconds = 0.25;
const smooth = (t: number): number => t * t * (3 - 2 * t);

type Listener = (pose: Pose) => void;

/** Is at home in one element; `dispose()` gives it back. */
export class Viewer {
  readonly element: HTMLElement;
  private scan_: Scan;
  private readonly stage: Stage;
  private readonly pictures: Pictures;
  private readonly controls: Controls;
  private readonly resizes: ResizeObserver;
  private readonly outlines = new OutlineLayer();
  private readonly listeners = new Set<Listener>();
  private readonly next = document.createElement('div');
  private readonly hint = document.createElement('div');
  private names: ReadonlyMap<number, string> = new Map();
  private path: readonly number[] = [];
  private hovered: number | undefined;
  private marks: ReadonlyMap<number, Mark> = new Map();
  private overlay: { layer: Layer; share: number } | undefined;
  private readonly rules: Rules | undefined;
  private places: ReadonlySet<number> | undefined;
  private pose_: Pose;
  private moving = false;
  private pick: ((direction: Direction) => void) | undefined;
  /** Counts what moves one: a later one ends those before. */
  private trips = 0;
  /** On the way; nothing while one stands. */
  private moment: Moment | undefined;
  private frame = 0;
  private animation = 0;
  private endAnimation: () => void = () => {};

  /** Resolves when the first panorama is on the screen. Throws ServerError, or Error without WebGL. */
  static async open(element: HTMLElement, options: ViewerOptions): Promise<Viewer> {
    const api = new Api(options.server);
    const scan = await api.scan(options.scan);
    const viewer = new Viewer(element, api, scan, options);
    const here = await viewer.panorama(viewer.pose_.viewpoint);
    viewer.stage.stand(here);
    if (options.heading === undefined && options.towards === undefined) viewer.lookAround(here);
    viewer.arrive();
    viewer.drawNow();
    performance.mark('enfilade-first-panorama');
    return viewer;
  }

  private constructor(element: HTMLElement, api: Api, scan: Scan, options: ViewerOptions) {
    this.element = element;
    this.scan_ = scan;
    this.rules = options.rules;
    this.pose_ = startPose(scan, options);
    this.pictures = new Pictures(api, scan.scan);
    this.stage = new Stage();
    element.classList.add('enfilade-viewer');
    if (options.rules) element.style.aspectRatio = String(options.rules.aspect);
    element.append(this.stage.canvas, this.outlines.element);
    for (const [part, name] of [[this.next, 'enfilade-next'], [this.hint, 'enfilade-hint']] as const) {
      part.className = name;
      part.hidden = true;
      part.ariaHidden = 'true'; // the list of steps says it
      element.append(part);
    }
    this.controls = new Controls(this);
    this.resizes = new ResizeObserver(() => this.resize());
    this.resizes.observe(element);
    this.resize();
  }

  get scan(): Scan {
    return this.scan_;
  }

  get pose(): Pose {
    return this.pose_;
  }

  /** The picture's size in CSS pixels, and its opening. */
  get view(): Camera {
    const { clientWidth: width, clientHeight: height } = this.element;
    return { width: Math.max(width, 1), height: Math.max(height, 1), vfov: this.pose_.vfov };
  }

  /** Called whenever the pose changes. Returns what ends it. */
  onChange(listener: Listener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  /** Where one can go, nearest to the middle of the view first. */
  steps(): Step[] {
    return navigable(this.scan, this.pose_.viewpoint, this.pose_, this.rules?.within)
      .filter(({ viewpoint }) => this.places?.has(viewpoint) ?? true);
  }

  /** From now on one can go to these viewpoints only. */
  confine(places: Iterable<number>): void {
    this.places = new Set(places);
    this.placeDiscs();
    this.tell();
    this.draw();
  }

  look(heading: number, elevation: number): void {
    const most = this.rules?.mostElevation ?? Math.PI / 2;
    this.setPose({
      ...this.pose_,
      heading: wrapHeading(heading),
      elevation: Math.min(Math.max(elevation, -most), most),
    });
  }

  /** Whether zoom() does anything. */
  get zooms(): boolean {
    return this.rules === undefined;
  }

  zoom(vfov: number): void {
    if (!this.zooms) return;
    this.setPose({ ...this.pose_, vfov: Math.min(Math.max(vfov, leastVfov), mostVfov) });
  }

  /**
   * Glides to a viewpoint; fades to one that is no step away, and where people asked for less motion.
   * False while on the way, or if it may not be.
   */
  async go(viewpoint: number): Promise<boolean> {
    if (this.moving || !this.scan.viewpoints[viewpoint]?.rotation || !this.may(viewpoint)) return false;
    this.moving = true;
    this.stopAnimation();
    const trip = this.trips;
    this.hoverAt();
    try {
      const there = await this.panorama(viewpoint);
      if (trip !== this.trips) return false;
      this.stage.head(there);
      const from = this.pose_.viewpoint;
      this.moment = { from, to: viewpoint, share: 0, heading: this.pose_.heading, elevation: this.pose_.elevation };
      this.tell(); // what lies over the picture goes
      const seconds = this.passage(from, viewpoint) === 'space'
        ? glideSeconds(norm(subtract(there.position, this.eye()))) : fadeSeconds;
      await this.animate(seconds, (share) => {
        const { heading, elevation } = this.pose_; // one may look around on the way
        this.moment = { from, to: viewpoint, share: smooth(share), heading, elevation };
        this.drawNow();
      });
      if (trip !== this.trips) return false;
      await this.stand(viewpoint);
    } finally {
      this.moving = false;
    }
    return true;
  }

  /** To any pose, without a glide. */
  async jump(pose: Partial<Pose>): Promise<void> {
    this.stopAnimation();
    this.pose_ = { ...this.pose_, ...pose };
    await this.stand(this.pose_.viewpoint);
  }

  /** Whether it is between two viewpoints. */
  get onTheWay(): boolean {
    return this.moment !== undefined;
  }

  /** Where a point of the picture looks. */
  directionAt(x: number, y: number): Direction {
    const { width, height, vfov } = this.view;
    const focal = height / 2 / Math.tan(vfov / 2);
    return directionTo([0, 0, 0], apply(worldFromCamera(this.pose_), [x - width / 2, y - height / 2, focal]));
  }

  /** From now on a click calls this instead of going anywhere; nothing: it goes again. */
  onPick(pick: ((direction: Direction) => void) | undefined): void {
    this.pick = pick;
    this.hoverAt();
  }

  /** Goes where a disc was clicked, if there is one. */
  goAt(x: number, y: number): void {
    if (this.pick) return this.pick(this.directionAt(x, y));
    const step = this.stepAt(x, y);
    if (step) void this.go(step.viewpoint);
  }

  /** Shows where a click at that point would go; without a point, nothing. Returns whether anywhere. */
  hoverAt(x?: number, y?: number): boolean {
    const step = x === undefined || y === undefined || this.moving || this.pick ? undefined : this.stepAt(x, y);
    if (step?.viewpoint === this.hovered) return step !== undefined;
    this.hovered = step?.viewpoint;
    this.stage.discs.choose(step?.viewpoint);
    this.hint.hidden = step === undefined;
    if (step) {
      const [left, top] = this.at(step.viewpoint)!;
      const name = this.names.get(step.viewpoint);
      this.hint.textContent = `${name ? `${name}, ` : ''}${step.distance.toFixed(1)} m`;
      this.hint.style.left = `${left}px`;
      this.hint.style.top = `${top}px`;
    }
    this.draw();
    return step !== undefined;
  }

  /** Names of viewpoints, of their rooms for instance, where people may know them. */
  setNames(names: ReadonlyMap<number, string>): void {
    this.names = names;
    this.tell();
  }

  /** The name of a viewpoint, if it has one. */
  name(viewpoint: number): string | undefined {
    return this.names.get(viewpoint);
  }

  /** The next viewpoint of the path, if one stands on it and it goes on. */
  get nextOnPath(): number | undefined {
    const k = this.path.indexOf(this.pose_.viewpoint);
    return k < 0 ? undefined : this.path[k + 1];
  }

  /** Marks a path on the floor: blue discs, start and goal with poles; yellow ones where a goal is seen. Empty: none. */
  setPath(path: readonly number[], seen: readonly number[] = []): void {
    this.path = path;
    this.pointOn();
    const marks = new Map<number, Mark>([...path.map((viewpoint) => [viewpoint, 'path'] as const),
      ...seen.map((viewpoint) => [viewpoint, 'seen'] as const)]);
    if (path.length > 0) {
      marks.set(path[0]!, 'start');
      marks.set(path.at(-1)!, 'goal');
    }
    this.setMarks(marks);
  }

  /** Marks viewpoints on the floor, over the discs of steps. */
  setMarks(marks: ReadonlyMap<number, Mark>): void {
    this.marks = marks;
    this.placeDiscs();
    this.draw();
  }

  /** Lines around what is seen from viewpoints, drawn while one stands there. Replaces those before. */
  setOutlines(outlines: readonly Outline[]): void {
    this.outlines.set(outlines);
    this.draw();
  }

  /** The same viewpoints with other edges. */
  setGraph(scan: Scan): void {
    this.scan_ = scan;
    this.placeDiscs();
    this.tell();
    this.draw();
  }

  /** Depth or classes over the colours; share 0 to 1. */
  async setOverlay(layer: Layer | undefined, share = 0.6): Promise<void> {
    this.overlay = layer && layer !== 'colour' ? { layer, share } : undefined;
    this.stage.stand(await this.panorama(this.pose_.viewpoint));
    this.draw();
  }

  flight(path: readonly number[]): Flight {
    return new Flight(this.scan, path, this.pose_);
  }

  /** Shows a moment of a flight. Resolves when it is on the screen. */
  async showMoment(moment: Moment): Promise<void> {
    const { from, to, share } = moment;
    if (this.hovered !== undefined) this.hoverAt();
    if (from !== this.pose_.viewpoint) {
      this.stage.stand(await this.panorama(from));
      this.pose_ = { ...this.pose_, viewpoint: from };
      this.placeDiscs();
    }
    if (to !== from) this.stage.head(await this.panorama(to));
    this.pose_ = { ...this.pose_, heading: moment.heading, elevation: moment.elevation };
    this.moment = share > 0 && to !== from ? moment : undefined;
    this.tell();
    this.draw();
  }

  /** The picture without discs, RGBA rows from the top, of any size: what the simulator draws. */
  capture(width: number, height: number): Uint8Array {
    const pixels = this.stage.capture(this.pose_, width, height);
    this.draw();
    return pixels;
  }

  dispose(): void {
    this.stopAnimation();
    cancelAnimationFrame(this.frame);
    this.resizes.disconnect();
    this.controls.dispose();
    this.pictures.dispose();
    this.stage.dispose();
    this.outlines.element.remove();
    this.next.remove();
    this.hint.remove();
    this.element.classList.remove('enfilade-viewer');
    this.element.style.removeProperty('aspect-ratio');
  }

  private may(viewpoint: number): boolean {
    if (this.rules) return this.steps().some((step) => step.viewpoint === viewpoint);
    return this.places?.has(viewpoint) ?? true;
  }

  private eye(): Vec3 {
    return this.scan.viewpoints[this.pose_.viewpoint]!.position;
  }

  private setPose(pose: Pose): void {
    this.pose_ = pose;
    if (this.hovered !== undefined) this.hoverAt(); // the disc is elsewhere now
    if (this.rules) this.placeDiscs(); // what can be gone to turns with the heading
    this.tell();
    this.draw();
  }

  private tell(): void {
    this.pointOn();
    for (const listener of this.listeners) listener(this.pose_);
  }

  private async stand(viewpoint: number): Promise<void> {
    this.stage.stand(await this.panorama(viewpoint));
    this.moment = undefined;
    this.pose_ = { ...this.pose_, viewpoint };
    this.arrive();
    this.draw();
  }

  private arrive(): void {
    this.hoverAt();
    this.placeDiscs();
    this.tell();
    for (const { viewpoint } of this.steps().slice(0, 4)) {
      if (!this.scan.viewpoints[viewpoint]!.rotation) continue;
      void this.panorama(viewpoint).then((panorama) => this.stage.prepare(panorama)).catch(() => {});
    }
  }

  /** What is to be seen at a viewpoint, with the overlay. Throws Error without pictures. */
  private async panorama(viewpoint: number): Promise<Panorama> {
    const { id, position, rotation, layers } = this.scan.viewpoints[viewpoint]!;
    if (!rotation) throw new Error(`viewpoint ${id} of ${this.scan.scan} has no pictures`);
    const overlay = this.overlay && layers.includes(this.overlay.layer) ? this.overlay : undefined;
    const [picture, laid, distances] = await Promise.all([
      this.pictures.get(id, 'colour'),
      overlay && this.pictures.get(id, overlay.layer),
      // Without them everything works, if less well.
      layers.includes('depth') ? this.pictures.distances(id).catch(() => undefined) : undefined,
    ]);
    return {
      position, rotation, picture,
      ...(overlay && laid && { overlay: { picture: laid, share: overlay.share } }),
      ...(distances && { distances }),
    };
  }

  /** Turns to where most is to be seen. */
  private lookAround({ distances, rotation, position }: Panorama): void {
    if (!distances) return; // then it looks to where one can go
    const steps = this.scan.viewpoints[this.pose_.viewpoint]!.neighbours
      .map((v) => directionTo(position, this.scan.viewpoints[v]!.position).heading);
    const reach = (heading: number) => reachOf(position, this.scan.viewpoints.map((viewpoint) => viewpoint.position), heading);
    this.pose_ = { ...this.pose_, heading: distances.surround.openHeading(rotation, steps, reach) };
  }

  private passage(from: number, to: number): Passage {
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
    return still || !this.scan.viewpoints[from]!.neighbours.includes(to) ? 'fade' : 'space';
  }

  /** Where the disc of a viewpoint is on the screen. */
  private at(viewpoint: number): readonly [number, number] | undefined {
    return project(this.view, this.pose_, this.eye(), floorBelow(this.scan, viewpoint));
  }

  private stepAt(x: number, y: number): Step | undefined {
    let best: Step | undefined;
    let least = reach;
    for (const step of this.steps()) {
      const at = this.at(step.viewpoint);
      const away = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (away < least) [best, least] = [step, away];
    }
    return best;
  }

  /** An arrow at the side where the path goes on, while that is out of sight. */
  private pointOn(): void {
    const next = this.nextOnPath;
    const step = next === undefined ? undefined : navigable(this.scan, this.pose_.viewpoint, this.pose_).find((s) => s.viewpoint === next);
    const { width, height, vfov } = this.view;
    const half = Math.atan(Math.tan(vfov / 2) * (width / height));
    this.next.hidden = step === undefined || Math.abs(step.relHeading) < half * 0.85;
    if (step) this.next.dataset['side'] = step.relHeading > 0 ? 'right' : 'left';
  }

  private placeDiscs(): void {
    const marks = new Map<number, Mark>();
    for (const { viewpoint } of this.steps()) marks.set(viewpoint, 'step');
    for (const [viewpoint, mark] of this.marks) marks.set(viewpoint, mark);
    if (!['start', 'goal'].includes(marks.get(this.pose_.viewpoint) ?? '')) {
      marks.delete(this.pose_.viewpoint); // one stands on it
    }
    this.stage.discs.set(this.scan, this.eye(), marks);
  }

  /** At the next frame, once, however often it is asked for. */
  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => this.drawNow());
  }

  private drawNow(): void {
    this.outlines.draw(this.moment ? undefined : this.pose_.viewpoint, this.view, this.pose_);
    if (this.moment) {
      const { from, to, share } = this.moment;
      this.stage.drawBetween(this.pose_, share, this.passage(from, to));
    } else {
      this.stage.draw(this.pose_);
    }
  }

  private animate(seconds: number, at: (share: number) => void): Promise<void> {
    return new Promise((resolve) => {
      this.endAnimation = resolve;
      const begin = performance.now();
      const step = (now: number) => {
        const share = seconds > 0 ? Math.min((now - begin) / 1000 / seconds, 1) : 1;
        at(Math.max(share, 0));
        if (share < 1) this.animation = requestAnimationFrame(step);
        else resolve();
      };
      this.animation = requestAnimationFrame(step);
    });
  }

  private stopAnimation(): void {
    ++this.trips;
    cancelAnimationFrame(this.animation);
    this.endAnimation();
  }

  private resize(): void {
    const { width, height } = this.view;
    this.stage.resize(width, height);
    this.drawNow(); // at once: an empty frame would flash
  }
}

function startPose(scan: Scan, options: ViewerOptions): Pose {
  const named = viewpointIndex(scan, options.viewpoint);
  if (options.viewpoint !== undefined && named < 0) {
    throw new Error(`${scan.scan} has no viewpoint ${options.viewpoint}`);
  }
  const first = scan.viewpoints.findIndex(({ included, rotation }) => included && rotation);
  const viewpoint = named >= 0 ? named : first;
  if (viewpoint < 0) throw new Error(`${scan.scan} has no pictures`);
  const { position, neighbours } = scan.viewpoints[viewpoint]!;
  const towards = viewpointIndex(scan, options.towards);
  const next = scan.viewpoints[towards >= 0 && towards !== viewpoint ? towards : (neighbours[0] ?? -1)];
  const along = next ? directionTo(position, next.position).heading : 0;
  return {
    viewpoint,
    heading: wrapHeading(options.heading ?? along), // towards somewhere to go, not a wall
    elevation: options.elevation ?? 0,
    vfov: options.rules?.vfov ?? Math.min(Math.max(options.vfov ?? degrees(60), leastVfov), mostVfov),
  };
}
