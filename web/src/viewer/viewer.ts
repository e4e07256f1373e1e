/** First person in a panorama, as a part of any page. */
import {
  apply, type Camera, type Direction, directionTo, norm, project, subtract, type Vec3, worldFromCamera, wrapDifference,
  wrapHeading,
} from '../geometry/geometry.ts';
import { navigable, type Step } from '../scan/navigation.ts';
import type { Layer, Scan } from '../scan/scan.ts';
import { Api, passSilence, reachability, Silence } from '../server/api.ts';
import { arrivalLook, endLook, firstPose, limitVfov, openHeading, usualVfov } from './arrival.ts';
import { Controls } from './controls.ts';
import { floorBelow, type Mark } from './discs.ts';
import { Flight, type Moment } from './flight.ts';
import type { Rules, ViewerOptions } from './options.ts';
import { type Outline, OutlineLayer } from './outline_layer.ts';
import { type Panorama, Pictures } from './panorama.ts';
import { type Passage, Stage } from './stage.ts';

/** Where one stands and looks. */
export interface Pose extends Direction {
  /** Index into Scan.viewpoints. */
  readonly viewpoint: number;
  /** Vertical opening, radians. */
  readonly vfov: number;
}

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
  private pointed: number | undefined;
  private hovered: number | undefined;
  private highlighted: number | undefined;
  private marks: ReadonlyMap<number, Mark> = new Map();
  private overlay: { layer: Layer; share: number } | undefined;
  private readonly rules: Rules | undefined;
  /** Whether the opening follows the picture's shape. */
  private fits: boolean;
  private places: ReadonlySet<number> | undefined;
  private pose_: Pose;
  private moving = false;
  private pick: ((direction: Direction) => void) | undefined;
  /** Counts what moves one: a later one ends those before. */
  private trips = 0;
  /** Counts moments of flights, of which the last that was asked for is shown. */
  private asked = 0;
  /** On the way; nothing while one stands. */
  private moment: Moment | undefined;
  /** Where one looks after the fade that is going on. */
  private arrival: Direction | undefined;
  private frame = 0;
  private animation = 0;
  private endAnimation: () => void = () => {};

  /** Resolves when the first panorama is on the screen. Throws ServerError, NotInScan, or Error without WebGL. */
  static async open(element: HTMLElement, options: ViewerOptions): Promise<Viewer> {
    const api = new Api(options.server);
    const scan = await api.scan(options.scan);
    const viewer = new Viewer(element, api, scan, options);
    const here = await viewer.panorama(viewer.pose_.viewpoint);
    viewer.stage.stand(here);
    if (options.heading === undefined && options.towards === undefined) {
      const { viewpoint, heading } = viewer.pose_;
      viewer.pose_ = { ...viewer.pose_, heading: openHeading(scan, viewpoint, here.distances?.surround) ?? heading };
    }
    viewer.arrive();
    viewer.drawNow();
    performance.mark('enfilade-first-panorama');
    return viewer;
  }

  private constructor(element: HTMLElement, api: Api, scan: Scan, options: ViewerOptions) {
    this.element = element;
    this.scan_ = scan;
    this.rules = options.rules;
    this.fits = !options.rules && options.vfov === undefined;
    this.pose_ = firstPose(scan, options);
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
    this.fits = false;
    this.setPose({ ...this.pose_, vfov: limitVfov(vfov) });
  }

  /**
   * Glides to a viewpoint; fades to one that is no step away, and where people asked for less motion.
   * One arrives with a view (arrival.ts), unless there are rules. False while on the way, or if it may not be.
   * @param chosen on a map or in a list: one looks around anew, also after one step
   */
  async go(viewpoint: number, chosen = false): Promise<boolean> {
    if (this.moving || !this.scan.viewpoints[viewpoint]?.rotation || !this.may(viewpoint)) return false;
    this.moving = true;
    this.stopAnimation();
    const trip = this.trips;
    this.hoverAt();
    try {
      const there = await this.panorama(viewpoint);
      if (trip !== this.trips) return false;
      this.stage.head(there);
      const { viewpoint: from, heading: begin, elevation: level } = this.pose_;
      const passage = this.passage(from, viewpoint);
      const end = this.lookAt(viewpoint, there, chosen);
      this.moment = { from, to: viewpoint, share: 0, heading: begin, elevation: level };
      this.arrival = end;
      this.tell(); // what lies over the picture goes
      const seconds = passage === 'space' ? glideSeconds(norm(subtract(there.position, this.eye()))) : fadeSeconds;
      let turned = this.pose_;
      await this.animate(seconds, (share) => {
        if (end && passage === 'space' && this.pose_ === turned) { // one may look around on the way
          const turn = wrapDifference(end.heading - begin) * smooth(share);
          turned = this.pose_ = { ...turned, heading: wrapHeading(begin + turn), elevation: level + (end.elevation - level) * smooth(share) };
        }
        const { heading, elevation } = this.pose_;
        this.moment = { from, to: viewpoint, share: smooth(share), heading, elevation };
        this.drawNow();
      });
      if (trip !== this.trips) return false;
      if (passage === 'fade') this.pose_ = { ...this.pose_, ...end }; // the picture has turned already
      await this.stand(viewpoint);
    } catch (error) {
      this.fail(error, trip, () => this.go(viewpoint, chosen));
      if (!(error instanceof Silence)) throw error;
      return false;
    } finally {
      this.moving = false;
    }
    return true;
  }

  /** To any pose, without a glide. To another viewpoint without a heading: with a view, as go() arrives. */
  async jump(pose: Partial<Pose>): Promise<void> {
    this.stopAnimation();
    const trip = this.trips;
    if (pose.vfov !== undefined) this.fits = false;
    const { viewpoint = this.pose_.viewpoint } = pose;
    const arrives = viewpoint !== this.pose_.viewpoint && pose.heading === undefined;
    try {
      const there = await this.panorama(viewpoint);
      if (trip !== this.trips) return; // one goes elsewhere now
      this.pose_ = { ...this.pose_, ...(arrives && this.lookAt(viewpoint, there, false)), ...pose };
      await this.stand(viewpoint);
    } catch (error) {
      this.fail(error, trip, () => this.jump(pose));
      throw error;
    }
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
    this.showChosen();
    this.draw();
    return step !== undefined;
  }

  /** Shows which disc is a viewpoint's, as pointing at it does, or where it is; nothing: none. */
  highlight(viewpoint: number | undefined): void {
    this.highlighted = viewpoint;
    this.pointTo(viewpoint);
    this.showChosen();
    this.draw();
  }

  /** Makes the chosen disc larger, and says what is there. */
  private showChosen(): void {
    const viewpoint = this.hovered ?? this.highlighted;
    this.stage.discs.choose(viewpoint);
    const at = viewpoint === undefined || this.moment ? undefined : this.at(viewpoint);
    const { width, height } = this.view;
    this.hint.hidden = !at || at[0] < 0 || at[0] > width || at[1] < 0 || at[1] > height;
    if (!at || viewpoint === undefined) return;
    const name = this.names.get(viewpoint);
    const away = norm(subtract(this.scan.viewpoints[viewpoint]!.position, this.eye()));
    this.hint.textContent = `${name ? `${name}, ` : ''}${away.toFixed(1)} m`;
    this.hint.style.left = `${at[0]}px`;
    this.hint.style.top = `${at[1]}px`;
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

  /** While this viewpoint is out of sight, an arrow at the side says where it is; nothing: where the path goes on. */
  pointTo(viewpoint: number | undefined): void {
    this.pointed = viewpoint;
    this.pointOn();
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
    const overlay = layer && layer !== 'colour' ? { layer, share } : undefined;
    const { viewpoint } = this.pose_;
    this.overlay = overlay;
    const here = await this.panorama(viewpoint);
    if (this.overlay !== overlay) return; // another was chosen
    if (this.pose_.viewpoint !== viewpoint) return this.setOverlay(layer, share); // one has gone on
    this.stage.stand(here);
    this.draw();
  }

  flight(path: readonly number[]): Flight {
    return new Flight(this.scan, path, this.pose_);
  }

  /** Shows a moment of a flight. Resolves when it is on the screen, or when something else is to be shown. */
  async showMoment(moment: Moment): Promise<void> {
    const { from, to, share } = moment;
    const [trip, asked] = [this.trips, ++this.asked];
    const isOver = () => trip !== this.trips || asked !== this.asked;
    if (this.hovered !== undefined) this.hoverAt();
    if (from !== this.pose_.viewpoint) {
      const here = await this.panorama(from);
      if (isOver()) return;
      this.stage.stand(here);
      this.pose_ = { ...this.pose_, viewpoint: from };
      this.placeDiscs();
    }
    if (to !== from) {
      const there = await this.panorama(to);
      if (isOver()) return;
      this.stage.head(there);
    }
    this.pose_ = { ...this.pose_, heading: moment.heading, elevation: moment.elevation };
    this.moment = share > 0 && to !== from ? moment : undefined;
    this.arrival = undefined;
    this.tell();
    this.draw();
  }

  /** At the end of a flight: turns to what is open, where a wall is right ahead. */
  async settle(): Promise<void> {
    const begin = this.pose_;
    const { distances } = await this.panorama(begin.viewpoint);
    const end = endLook(this.scan, begin.viewpoint, begin.heading, distances?.surround);
    if (!end || this.moving || this.pose_ !== begin) return;
    const turn = wrapDifference(end.heading - begin.heading);
    let turned = begin;
    await this.animate(Math.abs(turn) / 2, (share) => {
      if (this.pose_ !== turned) return; // one looks elsewhere oneself
      this.look(begin.heading + turn * smooth(share), begin.elevation + (end.elevation - begin.elevation) * smooth(share));
      turned = this.pose_;
    });
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

  /** One stays where one was. If the server does not answer, which the page says, the trip is made once it does, if no other was begun. */
  private fail(error: unknown, trip: number, again: () => Promise<unknown>): void {
    if (trip !== this.trips) return;
    if (this.moment) {
      this.moment = undefined;
      this.tell();
      this.draw();
    }
    if (!(error instanceof Silence)) return;
    reachability.addEventListener('back', () => {
      if (trip === this.trips) again().catch(passSilence);
    }, { once: true });
  }

  private eye(): Vec3 {
    return this.scan.viewpoints[this.pose_.viewpoint]!.position;
  }

  private setPose(pose: Pose): void {
    this.pose_ = pose;
    this.hovered = undefined; // the disc is elsewhere now
    this.showChosen();
    if (this.rules) this.placeDiscs(); // what can be gone to turns with the heading
    this.tell();
    this.draw();
  }

  private tell(): void {
    this.pointOn();
    for (const listener of this.listeners) listener(this.pose_);
  }

  private async stand(viewpoint: number): Promise<void> {
    const trip = this.trips;
    const there = await this.panorama(viewpoint);
    if (trip !== this.trips) return; // one goes elsewhere now
    this.stage.stand(there);
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

  /** Where one looks on arrival at another viewpoint; nothing: as before, which is what agents do. */
  private lookAt(to: number, { distances }: Panorama, chosen: boolean): Direction | undefined {
    const { viewpoint: from, heading, elevation } = this.pose_;
    const k = this.path.indexOf(to);
    const look = { heading, elevation };
    const next = k < 0 ? undefined : this.path[k + 1];
    const end = this.rules ? look : arrivalLook(this.scan, { from, to, chosen, look, next, surround: distances?.surround });
    return end === look ? undefined : end;
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

  /** An arrow at the side where the path goes on, or where pointTo() has it, while that is out of sight. */
  private pointOn(): void {
    const next = this.pointed ?? this.nextOnPath;
    const at = next === undefined || next === this.pose_.viewpoint ? undefined : this.scan.viewpoints[next]?.position;
    const turn = at && wrapDifference(directionTo(this.eye(), at).heading - this.pose_.heading);
    const { width, height, vfov } = this.view;
    const half = Math.atan(Math.tan(vfov / 2) * (width / height));
    this.next.hidden = turn === undefined || Math.abs(turn) < half * 0.85;
    if (turn !== undefined) this.next.dataset['side'] = turn > 0 ? 'right' : 'left';
  }

  private placeDiscs(): void {
    const marks = new Map<number, Mark>();
    for (const { viewpoint } of this.steps()) marks.set(viewpoint, 'step');
    for (const [viewpoint, mark] of this.marks) marks.set(viewpoint, mark);
    if (!['start', 'goal'].includes(marks.get(this.pose_.viewpoint) ?? '')) {
      marks.delete(this.pose_.viewpoint); // one stands on it
    }
    this.stage.discs.set(this.scan, this.eye(), marks);
    this.showChosen();
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
      this.stage.drawBetween(this.pose_, share, this.passage(from, to), this.arrival);
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
    const vfov = this.fits ? usualVfov({ width, height }) : this.pose_.vfov;
    if (vfov !== this.pose_.vfov) {
      this.pose_ = { ...this.pose_, vfov };
      this.tell();
    }
    this.stage.resize(width, height);
    this.drawNow(); // at once: an empty frame would flash
  }
}
