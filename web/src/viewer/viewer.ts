/** First person in a panorama, as a part of any page. */
import * as three from 'three';
import {
  type Camera,
  degrees,
  type Direction,
  directionTo,
  mix,
  project,
  type Vec3,
  wrapHeading,
  worldFromCamera,
} from '../geometry.ts';
import { halfFieldOfView, navigable, type Step } from '../navigation.ts';
import { Api, type Layer, type Scan, viewpointIndex } from '../scan.ts';
import { Controls } from './controls.ts';
import { Discs, floorBelow, type Mark } from './discs.ts';
import { Flight, type Moment } from './flight.ts';
import { PanoramaBox, Pictures } from './panorama.ts';

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
  readonly vfov?: number;
  /** The server's address; absent: that of the page. */
  readonly server?: string;
  /** Absent: one may look and go everywhere. */
  readonly rules?: Rules;
}

/** What one may see and do, where that is less than everything. */
export interface Rules {
  /** Only steps that lie within so many radians of the heading can be taken. */
  readonly within: number;
  /** One looks so far up and down at most, radians. */
  readonly mostElevation: number;
  /** The vertical opening, which stays, radians. */
  readonly vfov: number;
  /** The picture is so many times as wide as high. */
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
/** A disc is hit from so many pixels away: a finger's width. */
const reach = 36;
const glideSeconds = 0.6;

type Listener = (pose: Pose) => void;

/** Is at home in one element; `dispose()` gives it back. */
export class Viewer {
  readonly element: HTMLElement;
  private scan_: Scan;
  private readonly renderer: three.WebGLRenderer;
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera(60, 1, 0.05, 100);
  private readonly here = new PanoramaBox(0);
  private readonly there = new PanoramaBox(1);
  private readonly discs = new Discs();
  private readonly pictures: Pictures;
  private readonly controls: Controls;
  private readonly resizes: ResizeObserver;
  private readonly listeners = new Set<Listener>();
  private marks: ReadonlyMap<number, Mark> = new Map();
  private overlay: { layer: Layer; share: number } | undefined;
  private readonly rules: Rules | undefined;
  private places: ReadonlySet<number> | undefined;
  private pose_: Pose;
  private moving = false;
  private frame = 0;
  private animation = 0;

  /** Resolves when the first panorama is on the screen. Throws ServerError, or Error without WebGL. */
  static async open(element: HTMLElement, options: ViewerOptions): Promise<Viewer> {
    const api = new Api(options.server);
    const scan = await api.scan(options.scan);
    const viewer = new Viewer(element, api, scan, options);
    await viewer.showPanorama(viewer.here, viewer.pose_.viewpoint);
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
    this.renderer = new three.WebGLRenderer({ antialias: true, preserveDrawingBuffer: false });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace; // values pass as they are
    this.renderer.domElement.classList.add('enfilade-canvas');
    element.classList.add('enfilade-viewer');
    if (options.rules) element.style.aspectRatio = String(options.rules.aspect);
    element.append(this.renderer.domElement);
    this.scene.add(this.here.mesh, this.there.mesh, this.discs.group);
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

  /** Glides to a viewpoint, at once where people asked for less motion. False while on the way, or if it may not be. */
  async go(viewpoint: number): Promise<boolean> {
    if (this.moving || !this.scan.viewpoints[viewpoint]?.rotation || !this.may(viewpoint)) return false;
    this.moving = true;
    this.stopAnimation();
    try {
      await this.showPanorama(this.there, viewpoint);
      const { viewpoint: from, heading, elevation } = this.pose_;
      const seconds = matchMedia('(prefers-reduced-motion: reduce)').matches ? 0 : glideSeconds;
      await this.animate(seconds, (share) =>
        this.drawMoment({ from, to: viewpoint, share, heading, elevation }),
      );
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

  /** Goes where a disc was clicked, if there is one. */
  goAt(x: number, y: number): void {
    const eye = this.eye();
    let best: number | undefined;
    let least = reach;
    for (const { viewpoint } of this.steps()) {
      const at = project(this.view, this.pose_, eye, floorBelow(this.scan, viewpoint));
      const away = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (away < least) [best, least] = [viewpoint, away];
    }
    if (best !== undefined) void this.go(best);
  }

  /** Marks a path on the floor: blue discs, start and goal with poles. Empty: none. */
  setPath(path: readonly number[]): void {
    const marks = new Map<number, Mark>(path.map((viewpoint) => [viewpoint, 'path']));
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
    await this.showPanorama(this.here, this.pose_.viewpoint);
    this.draw();
  }

  flight(path: readonly number[]): Flight {
    return new Flight(this.scan, path, this.pose_);
  }

  /** Shows a moment of a flight. Resolves when it is on the screen. */
  async showMoment(moment: Moment): Promise<void> {
    const { from, to, share } = moment;
    if (from !== this.pose_.viewpoint || !this.here.mesh.visible) {
      await this.showPanorama(this.here, from);
      this.pose_ = { ...this.pose_, viewpoint: from };
      this.placeDiscs();
    }
    if (to !== from) await this.showPanorama(this.there, to);
    this.pose_ = { ...this.pose_, heading: moment.heading, elevation: moment.elevation };
    this.tell();
    if (share === 0 || to === from) this.draw();
    else this.drawMoment(moment);
  }

  /** The picture without discs, RGBA rows from the top, of any size: what the simulator draws. */
  capture(width: number, height: number): Uint8Array {
    const target = new three.WebGLRenderTarget(width, height);
    const pixels = new Uint8Array(width * height * 4);
    this.discs.group.visible = false;
    this.aim(this.eye(), this.pose_, width / height);
    this.renderer.setRenderTarget(target);
    this.renderer.render(this.scene, this.camera);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    this.renderer.setRenderTarget(null);
    this.discs.group.visible = true;
    target.dispose();
    this.draw();
    return flipped(pixels, width * 4);
  }

  dispose(): void {
    this.stopAnimation();
    cancelAnimationFrame(this.frame);
    this.resizes.disconnect();
    this.controls.dispose();
    this.pictures.dispose();
    this.here.dispose();
    this.there.dispose();
    this.discs.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
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
    if (this.rules) this.placeDiscs(); // what can be gone to turns with the heading
    this.tell();
    this.draw();
  }

  private tell(): void {
    for (const listener of this.listeners) listener(this.pose_);
  }

  private async stand(viewpoint: number): Promise<void> {
    await this.showPanorama(this.here, viewpoint);
    this.there.setOpacity(0);
    this.pose_ = { ...this.pose_, viewpoint };
    this.arrive();
    this.draw();
  }

  private arrive(): void {
    this.placeDiscs();
    this.tell();
    for (const { viewpoint } of this.steps().slice(0, 4)) {
      const { id, rotation } = this.scan.viewpoints[viewpoint]!;
      if (rotation) void this.pictures.get(id, 'colour').catch(() => {});
    }
  }

  private async showPanorama(box: PanoramaBox, viewpoint: number): Promise<void> {
    const { id, position, rotation, layers } = this.scan.viewpoints[viewpoint]!;
    if (!rotation) throw new Error(`viewpoint ${id} of ${this.scan.scan} has no pictures`);
    const picture = await this.pictures.get(id, 'colour');
    const overlay =
      this.overlay && layers.includes(this.overlay.layer)
        ? await this.pictures.get(id, this.overlay.layer)
        : undefined;
    box.show(position, rotation, picture);
    box.setOverlay(overlay, this.overlay?.share ?? 0);
    box.setOpacity(box === this.here ? 1 : 0);
  }

  private placeDiscs(): void {
    const marks = new Map<number, Mark>();
    for (const { viewpoint } of this.steps()) marks.set(viewpoint, 'step');
    for (const [viewpoint, mark] of this.marks) marks.set(viewpoint, mark);
    if (!['start', 'goal'].includes(marks.get(this.pose_.viewpoint) ?? '')) {
      marks.delete(this.pose_.viewpoint); // one stands on it
    }
    this.discs.set(this.scan, this.eye(), marks);
  }

  private aim(eye: Vec3, direction: Direction, aspect: number): void {
    const m = worldFromCamera(direction);
    // three.js cameras look along -z with y up; ours along +z with y down.
    const pose = new three.Matrix4().set(
      m[0], -m[1], -m[2], eye[0],
      m[3], -m[4], -m[5], eye[1],
      m[6], -m[7], -m[8], eye[2],
      0, 0, 0, 1,
    );
    pose.decompose(this.camera.position, this.camera.quaternion, this.camera.scale);
    this.camera.fov = (this.pose_.vfov * 180) / Math.PI;
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  private drawMoment({ from, to, share, heading, elevation }: Moment): void {
    const [a, b] = [this.scan.viewpoints[from]!.position, this.scan.viewpoints[to]!.position];
    this.there.setOpacity(share);
    this.aim(mix(a, b, share), { heading, elevation }, this.view.width / this.view.height);
    this.renderer.render(this.scene, this.camera);
  }

  /** At the next frame, once, however often it is asked for. */
  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => this.drawNow());
  }

  private drawNow(): void {
    this.there.setOpacity(0);
    this.aim(this.eye(), this.pose_, this.view.width / this.view.height);
    this.renderer.render(this.scene, this.camera);
  }

  private animate(seconds: number, at: (share: number) => void): Promise<void> {
    return new Promise((resolve) => {
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
    cancelAnimationFrame(this.animation);
  }

  private resize(): void {
    const { width, height } = this.view;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.draw();
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
  const next = neighbours[0] === undefined ? undefined : scan.viewpoints[neighbours[0]];
  const along = next ? directionTo(position, next.position).heading : 0;
  return {
    viewpoint,
    heading: wrapHeading(options.heading ?? along), // towards somewhere to go, not a wall
    elevation: options.elevation ?? 0,
    vfov: options.rules?.vfov ?? Math.min(Math.max(options.vfov ?? degrees(60), leastVfov), mostVfov),
  };
}

/** Rows in the other order: OpenGL's first is the lowest. */
function flipped(pixels: Uint8Array, stride: number): Uint8Array {
  const out = new Uint8Array(pixels.length);
  for (let row = 0, last = pixels.length - stride; row <= last; row += stride) {
    out.set(pixels.subarray(last - row, last - row + stride), row);
  }
  return out;
}
